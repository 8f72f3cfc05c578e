// @ts-check
// The page, driven in a headless Chromium as a person would, by mouse and keys, over WebDriver. Its bits, its
// search and its fingerprints are compared with what the same code gives on this machine.
//
//     node web/tests/page.mjs heli.html FINGERPRINTS GAINS.toml [SCREENSHOTS]

import assert from "node:assert/strict";
import { readFileSync, mkdirSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium } from "./chromium.mjs";
import { delayOfStop } from "./stop.mjs";

const [page, fingerprints, gains, screenshots] = process.argv.slice(2);
const browser = await Chromium.start();
/** @type {string[]} */
const passed = [];
const begun = Date.now();

/** @param {string} name @param {() => Promise<void>} work */
async function step(name, work) {
  const from = Date.now();
  await work();
  passed.push(name);
  console.log(`  ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
}

/** A machine that is busy draws slowly, and then time passes slowly on the page: it is helped on. */
const sooner = async (/** @type {string} */ expression, /** @type {number} */ most) => {
  const later = `new Promise((go) => setTimeout(() => go(${expression}), 120))`;
  const look = `(window.twinrotor.clock.pass(200), ${later})`;
  await browser.until(look, most);
};
const state = (/** @type {string} */ wanted, most = 40_000) =>
  sooner(`document.querySelector("#state").textContent === "${wanted}"`, most);
const enabled = (/** @type {string} */ id, most = 40_000) =>
  sooner(`!document.querySelector("#${id}").disabled`, most);
const ask = (/** @type {unknown} */ request) =>
  browser.value(`window.twinrotor.machine.ask(${JSON.stringify(request)})`);
const last = (/** @type {string} */ column) => browser.value(`window.twinrotor.samples.row().${column}`);
const choose = (/** @type {string} */ id, /** @type {string} */ value) =>
  browser.run(`const list = document.querySelector("#${id}");
    list.value = "${value}";
    list.dispatchEvent(new Event("change"));`);
const shot = async (
  /** @type {string} */ name,
  /** @type {number} */ width,
  /** @type {number} */ height,
  dark = false,
) => {
  if (!screenshots) return;
  mkdirSync(screenshots, { recursive: true });
  await browser.size(width, height, dark);
  writeFileSync(join(screenshots, name), await browser.screenshot());
};

async function journey() {
  await step("opens from a file, without a network", async () => {
    await browser.open(`${pathToFileURL(resolve(page))}#preset=aero2&speed=4`);
    await state("disarmed");
    assert.equal(await browser.value("document.querySelector('#preset').value"), "aero2");
  });
  await step("says in words why it cannot be armed", async () => {
    assert.equal(await browser.value("document.querySelector('#arm').disabled"), true);
    const why = await browser.value("document.querySelector('#arm-why').textContent");
    assert.match(why, /the encoders have no zero yet; the first-power check has not been passed/);
  });
  await step("checks the wiring and zeroes", async () => {
    await choose("speed", "20");
    await browser.click("#check");
    await state("checking");
    await sooner("document.querySelector('#state').textContent === 'disarmed'", 60_000);
    assert.doesNotMatch(await browser.value("document.querySelector('#arm-why').textContent"), /check/);
    await browser.click("#zero");
    await state("ready", 30_000);
  });
  await step("arms only after a second's hold", async () => {
    await choose("speed", "1");
    await browser.hold("#arm", 200);
    await new Promise((go) => setTimeout(go, 1_500));
    assert.equal(await browser.value("document.querySelector('#state').textContent"), "ready");
    await browser.hold("#arm", 1_500);
    await state("armed");
  });
  await step("stops within 100 ms of the key, by Space and by Esc", async () => {
    for (const key of [" ", "Escape"]) {
      await ask({ aim: { pitch_deg: 15, yaw_deg: 0 } });
      await sooner("Math.abs(window.twinrotor.samples.row().main_volts) > 1", 20_000);
      const delay = await delayOfStop(browser, key);
      console.log(`    ${JSON.stringify(key)}: ${delay.toFixed(0)} ms`);
      assert.ok(delay < 100, `${JSON.stringify(key)}: ${delay} ms`);
      await sooner("document.querySelector('#state').textContent !== 'armed'", 10_000);
      await enabled("arm", 20_000);
      // By the keyboard alone.
      await browser.value("document.querySelector('#arm').focus()");
      await browser.key("Enter", 1_500);
      await state("armed");
      await new Promise((go) => setTimeout(go, 500));
    }
  });
  await step("flies a step, with its numbers", async () => {
    await choose("speed", "4");
    await browser.click("#fly");
    await sooner("!document.querySelector('#flights').hidden", 60_000);
    const numbers = await browser.value("document.querySelector('#flight-numbers').innerText");
    // Whether it settles in time depends on how warm the motors are.
    assert.match(numbers, /settling 2 %, pitch \[s\]\s+(–|\d+\.\d+)/);
    assert.match(numbers, /ISE, pitch \[rad² s\]\s+0\.\d+/);
  });
  await step("tries a setting, takes it back, tries and accepts it", async () => {
    const [name, value] = await browser.value(`(() => {
      const box = document.querySelector(".setting[data-name='lead.factor']");
      const slider = box.querySelector("input[type=range]");
      slider.value = "1";
      slider.dispatchEvent(new Event("input"));
      return [box.dataset.name, slider.valueAsNumber];
    })()`);
    // At level: a board takes a trial back whose error is twice that of late.
    await browser.value("window.twinrotor.clock.pass(6000)");
    await browser.key("t");
    await enabled("accept");
    await browser.click("#revert");
    await sooner("document.querySelector('#trial').textContent === ''", 10_000);
    await browser.click("#try");
    await enabled("accept");
    await browser.click("#accept");
    await sooner("document.querySelector('#trial').textContent === 'accepted, not saved'", 10_000);
    const { rows } = await ask("settings");
    assert.equal(rows.find((/** @type {any} */ row) => row.name === name).accepted, value);
  });
  await step("lays the second step over the first", async () => {
    await browser.click("#fly");
    await sooner("document.querySelectorAll('#flight-numbers thead th').length === 3", 60_000);
    const flights = await ask("flights");
    assert.notEqual(flights[0].report.pitch.ise, flights[1].report.pitch.ise);
  });
  await step("finds the first lesson's task done, by the numbers of both", async () => {
    await browser.value("document.querySelector('#lessons').open = true");
    await browser.until("document.querySelectorAll('#lesson-checks .met').length === 3", 10_000);
    assert.match(await browser.value("document.querySelector('#lesson').textContent"), /1\. Rotor lag ✓/);
    assert.equal(await browser.value("document.querySelectorAll('#lesson option').length"), 9);
    await shot("lesson.png", 1280, 800);
    await browser.value("document.querySelector('#lessons').open = false");
  });
  await step("looks as it should", async () => {
    await choose("speed", "1");
    await browser.value("window.scrollTo(0, 0)");
    await shot("desktop.png", 1280, 800);
    await shot("desktop-dark.png", 1280, 800, true);
    await shot("phone.png", 390, 844);
    await browser.value("document.querySelector('.middle').scrollIntoView()");
    await shot("phone-plots.png", 390, 844);
    await browser.size(390, 844, false);
    // Nothing is wider than a phone, once the plots have found their size.
    await browser.until(
      "document.documentElement.scrollWidth === document.documentElement.clientWidth",
      10_000,
    );
    await browser.size(1280, 800, false);
  });
  await step("a stuck encoder is found by the board, mended, cleared", async () => {
    await choose("speed", "4");
    await browser.click("[data-fault=pitch-stuck]");
    await ask({ aim: { pitch_deg: 10, yaw_deg: 30 } });
    await state("fault");
    assert.match(
      await browser.value("document.querySelector('#cause').textContent"),
      /encoder does not show/,
    );
    await browser.click("[data-fault=pitch-stuck]");
    await enabled("clear", 20_000);
    await browser.click("#clear");
    await sooner("document.querySelector('#state').textContent !== 'fault'", 20_000);
  });
  await step("gives the draft as the gains file that the module writes", async () => {
    await browser.click("#export");
    const text = readFileSync(await browser.downloaded("gains.toml"), "utf8");
    assert.equal(text, await ask("export"));
    assert.match(text, /^\[lead\]\n(.*\n)*?factor = 1\.0$/m);
  });
  await step("keeps its state in the address", async () => {
    await choose("scenario", "2");
    await browser.until("location.hash.includes('scenario=2')", 10_000);
    assert.match(await browser.value("location.hash"), /preset=aero2/);
  });
  await step("searches as the command line does, to the byte, within 5 s", async () => {
    await choose("preset", "paper");
    // The sliders of another controller have another height: what stands below them moves.
    await browser.until(
      `window.twinrotor.machine.ask("settings").then(({ rows }) =>
        rows.map(({ name }) => name).join() ===
          [...document.querySelectorAll(".setting")].map((box) => box.dataset.name).join())`,
      20_000,
    );
    await browser.value("document.querySelector('#search').open = true");
    await browser.value("document.querySelector('#seed').value = '7'");
    await browser.click("#tune");
    await browser.until("document.querySelector('#tune-told').dataset.gains !== undefined", 60_000);
    const told = await browser.value("document.querySelector('#tune-told').textContent");
    const found = await browser.value("document.querySelector('#tune-told').dataset.gains");
    assert.equal(found, readFileSync(gains, "utf8"));
    console.log(`    ${told}`);
    assert.ok(Number(told.match(/([\d.]+) s$/)?.[1]) < 5, told);
    await shot("search.png", 1280, 800);
  });
  await step("gives the bits of this machine over long flights", async () => {
    for (const line of readFileSync(fingerprints, "utf8").trim().split("\n")) {
      const [preset, scenario, expected] = line.split(" ");
      const ticks = 1_000_000;
      assert.equal(
        await ask({ fingerprint: { preset, scenario, ticks } }),
        expected,
        `${preset} ${scenario}`,
      );
    }
  });
  assert.ok((await last("time")) > 0);
  assert.deepEqual(await browser.troubles(), []);
  const outside = (await browser.requests()).filter((url) => !/^(file|blob|data):/.test(url));
  assert.deepEqual(outside, []);
}

try {
  await journey();
  const seconds = (Date.now() - begun) / 1000;
  console.log(`${passed.length} steps passed in ${seconds.toFixed(0)} s`);
} finally {
  await browser.close();
}
