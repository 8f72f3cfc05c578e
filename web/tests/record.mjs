// @ts-check
// Recorded flights in the page, in a headless Chromium: one of `host-sim fly --record`, chosen in both of its
// formats, one of `host-sim simulate --csv`, dropped, and one that the page has recorded itself.
//
//     node web/tests/record.mjs heli.html FLOWN.csv FLOWN.mcap SIMULATED.csv

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium } from "./chromium.mjs";
import { choose, compare, inDegrees, playsAndPauses, same, seek, shown, table } from "./played.mjs";

const [page, flown, packed, simulated] = process.argv.slice(2);
const browser = await Chromium.start();
const begun = Date.now();

/** What the page records has every tick, and is opened again. */
async function recorded() {
  await browser.click("#record-begin");
  await browser.until("document.querySelector('#record-told').textContent.includes('ticks')", 5_000);
  await new Promise((go) => setTimeout(go, 2_000));
  assert.equal(await browser.value("document.querySelector('#record-begin').textContent"), "end the record");
  await browser.click("#record-begin");
  const file = await browser.downloaded("flight.csv");
  const rows = table(file);
  assert.ok(rows.length > 300, `${rows.length} rows`);
  rows.forEach((row, k) => {
    assert.equal(Number(row.tick), Number(rows[0].tick) + k, "every tick is there");
    assert.equal(row.gap, "0");
  });
  const head = (/** @type {string} */ name) => readFileSync(name, "utf8").split("\n", 1)[0];
  assert.equal(head(file), head(flown), "the columns of fly");
  await choose(browser, file);
  await seek(browser, 0.25);
  same((await shown(browser)).pitch, inDegrees(rows[250].pitch), "pitch");
  await browser.click("#play-end");
}

async function journey() {
  await browser.open(pathToFileURL(resolve(page)).href);
  // One that is none is told, and changes nothing.
  await browser.choose("#record", page);
  const told = "document.querySelector('#told').textContent";
  await browser.until(`${told}.includes("the recorded flight: it has no column t")`, 5_000);
  assert.equal(await browser.value("document.querySelector('#play').hidden"), true);
  await choose(browser, flown);
  assert.equal(await browser.value(told), "");
  assert.equal(await browser.value("document.querySelector('.steps').checkVisibility()"), false);
  await playsAndPauses(browser);
  await compare(browser, table(flown));
  // By ticks from there, and to the end, where it stays.
  for (let k = 0; k < 5; k += 1) await browser.click("#tick");
  same((await shown(browser)).time, 5.01, "time");
  await browser.run("window.twinrotor.clock.pass(60_000)");
  const last = Math.floor(Number(table(flown).at(-1)?.t) * 200) / 200;
  same((await shown(browser)).time, last, "time");
  assert.equal(await browser.value("window.twinrotor.samples.length"), last * 200 + 1);
  // The other format has the same flight.
  await choose(browser, packed);
  await compare(browser, table(flown));
  // Another is dropped.
  const text = JSON.stringify(readFileSync(simulated, "utf8"));
  await browser.run(`const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([${text}], "simulated.csv"));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));`);
  await browser.until("document.querySelector('#play-name').textContent === 'simulated.csv'", 10_000);
  await seek(browser, 2);
  same((await shown(browser)).pitch, inDegrees(table(simulated)[2_000].theta), "pitch");
  // What a key would do to a board that is not seen, it does not do.
  await browser.run(`window.clicks = 0;
    const button = document.querySelector("#fly");
    button.disabled = false;
    button.addEventListener("click", () => (window.clicks += 1));`);
  await browser.key("f");
  assert.equal(await browser.value("window.clicks"), 0);
  // The simulated board has stood still meanwhile, and is there again with what it told before.
  const before = await browser.value("window.twinrotor.live.length");
  assert.ok(before > 0);
  await browser.click("#play-end");
  assert.equal(await browser.value("window.twinrotor.samples.length"), before);
  await browser.click("#run");
  await browser.until("document.querySelector('#state').textContent === 'disarmed'", 10_000);
  assert.equal(await browser.value("document.querySelector('.steps').checkVisibility()"), true);
  await recorded();
  assert.deepEqual(await browser.troubles(), []);
}

try {
  await journey();
  const seconds = ((Date.now() - begun) / 1000).toFixed(0);
  console.log(`flights are recorded; records are opened, played, paused and sought: ${seconds} s`);
} finally {
  await browser.close();
}
