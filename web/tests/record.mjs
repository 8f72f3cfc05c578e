// @ts-check
// Recorded flights in the page, in a headless Chromium: one of `host-sim fly --record`, chosen, and one of
// `host-sim simulate --csv`, dropped.
//
//     node web/tests/record.mjs heli.html FLOWN.csv SIMULATED.csv

import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium, installed } from "./chromium.mjs";

const [page, flown, simulated] = process.argv.slice(2);
const program = installed();
if (!program) {
  console.log("not run: there is no Chromium here (apt-get install chromium)");
  process.exit(0);
}
const browser = new Chromium(program);
const shown = () => browser.value("({ ...window.twinrotor.samples.row() })");
const rest = (/** @type {number} */ ms) => new Promise((go) => setTimeout(go, ms));
const seek = (/** @type {number} */ time) =>
  browser.value(`(() => {
    const slider = document.querySelector("#play-at");
    slider.value = "${time}";
    slider.dispatchEvent(new Event("input"));
  })()`);

/** The rows of a file by name. @param {string} file */
function table(file) {
  const [head, ...lines] = readFileSync(file, "utf8").trim().split("\n");
  const names = head.split(",");
  return lines.map((line) => Object.fromEntries(line.split(",").map((value, k) => [names[k], value])));
}

/** @param {number} got @param {number} wanted @param {string} what */
function same(got, wanted, what) {
  const near = Math.abs(got - wanted) <= 1e-6 * Math.max(1, Math.abs(wanted));
  assert.ok(near, `${what}: ${got} is not ${wanted}`);
}
const degrees = 180 / Math.PI;

async function choose(/** @type {string} */ file) {
  const { root } = await browser.send("DOM.getDocument");
  const { nodeId } = await browser.send("DOM.querySelector", { nodeId: root.nodeId, selector: "#record" });
  await browser.send("DOM.setFileInputFiles", { nodeId, files: [resolve(file)] });
}

/** What the page records has every tick, and is opened again. */
async function recorded() {
  await browser.value(`(() => {
    const make = URL.createObjectURL;
    URL.createObjectURL = (blob) => {
      blob.text().then((text) => (window.kept = text));
      return make(blob);
    };
  })()`);
  await browser.click("#record-begin");
  await browser.until("document.querySelector('#record-told').textContent.includes('ticks')", 5_000);
  await rest(2_000);
  assert.equal(
    await browser.value("document.querySelector('#record-begin').textContent"),
    "end the record",
  );
  await browser.click("#record-begin");
  await browser.until("window.kept !== undefined", 10_000);
  const text = await browser.value("window.kept");
  const file = `${flown}.page.csv`;
  writeFileSync(file, text);
  const rows = table(file);
  assert.ok(rows.length > 300, `${rows.length} rows`);
  rows.forEach((row, k) => {
    assert.equal(Number(row.tick), Number(rows[0].tick) + k, "every tick is there");
    assert.equal(row.gap, "0");
  });
  const head = (/** @type {string} */ name) => readFileSync(name, "utf8").split("\n", 1)[0];
  assert.equal(head(file), head(flown), "the columns of fly");
  await choose(file);
  await browser.until("!document.querySelector('#play').hidden", 10_000);
  await seek(0.25);
  same((await shown()).pitch, Number(rows[250].pitch) * degrees, "pitch");
  await browser.click("#play-end");
}

async function journey() {
  await browser.open(pathToFileURL(resolve(page)).href);
  await browser.send("DOM.enable");
  // One that is none is told, and changes nothing.
  await choose(page);
  const told = "document.querySelector('#told').textContent";
  await browser.until(`${told}.includes("the recorded flight: it has no column t")`, 5_000);
  assert.equal(await browser.value("document.querySelector('#play').hidden"), true);
  await choose(flown);
  await browser.until("!document.querySelector('#play').hidden", 10_000);
  await browser.until("document.querySelector('#state').textContent === 'a record'", 5_000);
  assert.equal(await browser.value(told), "");
  assert.equal(await browser.value("document.querySelector('.steps').checkVisibility()"), false);
  // It plays by itself, and stands when it is paused.
  await browser.until("window.twinrotor.samples.row().time > 0.2", 20_000);
  await browser.click("#run");
  const { time } = await shown();
  await rest(400);
  assert.equal((await shown()).time, time);
  // What is shown is what was recorded; what a tick decided acts in the next.
  const rows = table(flown);
  for (const tick of [3_000, 5_005]) {
    await seek(tick / 1000);
    const [row, next, got] = [rows[tick], rows[tick + 1], await shown()];
    assert.equal(Number(row.t), tick / 1000);
    same(got.time, Number(row.t), "time");
    for (const [name, column] of [
      ["pitch", "pitch"],
      ["yaw", "yaw"],
      ["pitch_reference", "ref_pitch"],
      ["yaw_rate", "rate_yaw"],
    ])
      same(got[name], Number(row[column]) * degrees, name);
    same(got.main_volts, Number(next.v0), "main_volts");
    same(got.tail_volts, Number(next.v1), "tail_volts");
    same(got.supply, Number(row.supply), "supply");
  }
  // By ticks from there, and to the end, where it stays.
  for (let k = 0; k < 5; k += 1) await browser.click("#tick");
  same((await shown()).time, 5.01, "time");
  await browser.value("window.twinrotor.clock.pass(60_000)");
  const last = Math.floor(Number(rows.at(-1)?.t) * 200) / 200;
  same((await shown()).time, last, "time");
  const kept = await browser.value("window.twinrotor.samples.length");
  assert.equal(kept, last * 200 + 1);
  // Another is dropped.
  const text = JSON.stringify(readFileSync(simulated, "utf8"));
  await browser.value(`(() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([${text}], "simulated.csv"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
  })()`);
  await browser.until("document.querySelector('#play-name').textContent === 'simulated.csv'", 10_000);
  await seek(2);
  same((await shown()).pitch, Number(table(simulated)[2_000].theta) * degrees, "pitch");
  // The simulated board has stood still meanwhile, and is there again.
  await browser.click("#play-end");
  await browser.click("#run");
  await browser.until("document.querySelector('#state').textContent === 'disarmed'", 10_000);
  assert.equal(await browser.value("document.querySelector('.steps').checkVisibility()"), true);
  await recorded();
  assert.deepEqual(browser.troubles, []);
}

try {
  await journey();
  console.log("flights are recorded; records are opened, played, paused and sought");
} finally {
  await browser.close();
}
