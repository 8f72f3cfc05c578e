// @ts-check
// Recorded flights in the page of `host-sim monitor`, beside a board: a page that plays one flies none, tells
// how the board is, and stops it as quickly as ever.
//
//     node web/tests/beside.mjs HOST-SIM FLOWN.csv FLOWN.mcap [SCREENSHOTS]

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Chromium } from "./chromium.mjs";
import { choose, compare, playsAndPauses, table } from "./played.mjs";
import { delayOfStop } from "./stop.mjs";

const [hostSim, flown, packed, screenshots] = process.argv.slice(2);
const browser = await Chromium.start();
const begun = Date.now();
const monitor = spawn(hostSim, ["monitor"], { stdio: ["ignore", "pipe", "inherit"] });
/** @type {Promise<string>} */
const url = new Promise((go) => monitor.stdout.once("data", (line) => go(String(line).trim())));

/** @param {string} name @param {() => Promise<void>} work */
async function step(name, work) {
  const from = Date.now();
  await work();
  console.log(`  ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
}
const told = (/** @type {string} */ id, /** @type {RegExp} */ words) =>
  browser.until(`${words}.test(document.querySelector("#${id}").textContent)`, 10_000);
const state = (/** @type {string} */ wanted) => told("state", new RegExp(`^${wanted}$`));
const ask = (/** @type {unknown} */ request) =>
  browser.value(`window.twinrotor.machine.ask(${JSON.stringify(request)})`);
const refusal = (/** @type {unknown} */ request) => ask(request).then(assert.fail, ({ message }) => message);

/** Another page, as far as the program sees one: it takes over, says that it is there, and arms. */
const another = `window.other = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
  const say = (what) => window.other.send(JSON.stringify({ number: 1, ...what }));
  window.arms = () => say({ request: { supervisor: "arm" } });
  window.other.onopen = () => {
    say({ take: true });
    setInterval(() => window.other.readyState === 1 && say({ request: "settings" }), 100);
  };`;

async function shot(/** @type {string} */ name, /** @type {number} */ width, /** @type {number} */ height) {
  if (!screenshots) return;
  mkdirSync(screenshots, { recursive: true });
  await browser.size(width, height, false);
  await browser.run("window.scrollTo(0, 0)");
  writeFileSync(join(screenshots, name), await browser.screenshot());
}

async function journey() {
  await step("a page that flies a board opens no record", async () => {
    await browser.open(await url);
    await state("armed");
    await browser.choose("#record", flown);
    await told("told", /the motors may turn, and a record would hide the board: stop it first/);
    assert.equal(await browser.value("document.querySelector('#play').hidden"), true);
    await state("armed");
    await browser.key("Escape");
    await state("ready");
  });
  const rows = table(flown);
  const opened = await browser.value("window.twinrotor.live.row().time");
  for (const file of [flown, packed])
    await step(`plays ${file.split(".").at(-1)}, row by row as in the file`, async () => {
      await choose(browser, file);
      if (file === flown) await playsAndPauses(browser);
      await compare(browser, rows);
    });
  await step("tells how the board is, and arms none", async () => {
    await told("play-told", /^The board is now: ready\. STOP, Space and Esc switch its motors off/);
    for (const hidden of [".steps", "#arm", "#take", "#settings", "#record-begin"])
      assert.equal(
        await browser.value(`document.querySelector("${hidden}").checkVisibility()`),
        false,
        hidden,
      );
    assert.match(await refusal({ supervisor: "arm" }), /take over first/);
  });
  await step("what is no record is told, and the other is played on", async () => {
    await browser.choose("#record", hostSim);
    await told("told", /it is no text; CSV and MCAP files are read/);
    await browser.choose("#record", new URL(import.meta.url).pathname);
    await told("told", /it has no column t/);
    assert.equal(await browser.value("document.querySelector('#state').textContent"), "a record");
  });
  await step("while it plays Space and Esc stop a board that another page flies", async () => {
    await browser.run(another);
    await browser.click("#run");
    for (const key of [" ", "Escape"]) {
      await browser.until("window.other.readyState === 1", 5_000);
      await browser.run("window.arms()");
      await told("play-told", /^The board is now: armed/);
      await browser.until("Math.abs(window.twinrotor.live.row().main_volts) > 1", 20_000);
      if (key === " ") await shot("record-monitor.png", 1280, 800);
      if (key === " ") await shot("record-monitor-phone.png", 390, 844);
      const delay = await delayOfStop(browser, key);
      console.log(`    ${JSON.stringify(key)}: ${delay.toFixed(0)} ms`);
      assert.ok(delay < 100, `${JSON.stringify(key)}: ${delay} ms`);
      await told("play-told", /^The board is now: ready/);
    }
    assert.equal(await browser.value("document.querySelector('#state').textContent"), "a record");
  });
  await step("closed, it shows the board again, of which no sample is lost, and flies it", async () => {
    await browser.run("window.other.close()");
    await browser.until("!window.twinrotor.machine.controlled", 5_000);
    await browser.click("#play-end");
    await state("ready");
    const times = await browser.value("Array.from(window.twinrotor.samples.window(['time'], 0, 1e9)[0])");
    const long = times.filter(
      (/** @type {number} */ time, /** @type {number} */ k) => time - times[k - 1] > 0.0075,
    );
    assert.deepEqual(long, []);
    const [first, last] = [times[0], times.at(-1)];
    assert.ok(first < opened && last > opened + 1, `${first} to ${last} s, ${opened} s`);
    await browser.until(
      "window.twinrotor.machine.controls && !document.querySelector('#arm').disabled",
      20_000,
    );
    await browser.hold("#arm", 1_500);
    await state("armed");
  });
  // A file that is refused is a request that failed.
  const troubles = (await browser.troubles()).filter((trouble) => !/status of 422/.test(trouble));
  assert.deepEqual(troubles, []);
  const own = new URL(await url).host;
  const asked = await browser.requests();
  assert.ok(asked.some((one) => one.endsWith("/record")));
  assert.deepEqual(
    asked.filter((one) => !/^(data|blob):/.test(one) && new URL(one).host !== own),
    [],
  );
}

try {
  await journey();
  console.log(`records beside a board passed in ${((Date.now() - begun) / 1000).toFixed(0)} s`);
} finally {
  monitor.kill("SIGKILL");
  await browser.close();
}
