// @ts-check
// The page in another browser, by hand: a headless Firefox flies it, stops it, has this machine's bits, and
// plays a record beside a board.
//
//     node --experimental-websocket web/tests/firefox.mjs heli.html FINGERPRINTS HOST-SIM FLOWN.csv [FIREFOX]

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Firefox } from "./bidi.mjs";
import { choose, compare, playsAndPauses, table } from "./played.mjs";
import { delayOfStop } from "./stop.mjs";

const [page, fingerprints, hostSim, flown, program = "firefox-esr"] = process.argv.slice(2);
const browser = new Firefox(program);
/** @type {import("node:child_process").ChildProcess | undefined} */
let monitor;
const state = (/** @type {string} */ wanted) =>
  browser.until(`document.querySelector("#state").textContent === "${wanted}"`, 60_000);
const pushes = () => browser.until("Math.abs(window.twinrotor.live.row().main_volts) > 1", 60_000);

async function stops() {
  await pushes();
  const delay = await delayOfStop(browser, "Escape");
  console.log(`  Esc: ${delay.toFixed(0)} ms`);
  assert.ok(delay < 100, `${delay} ms`);
}

async function alone() {
  await browser.open(`${pathToFileURL(resolve(page))}#preset=aero2&speed=4`);
  for (const line of readFileSync(fingerprints, "utf8").trim().split("\n")) {
    const [preset, scenario, expected] = line.split(" ");
    const request = JSON.stringify({ fingerprint: { preset, scenario, ticks: 1_000_000 } });
    const found = await browser.value(`window.twinrotor.machine.ask(${request})`);
    assert.equal(found, expected, `${preset} ${scenario}`);
  }
  await browser.click("#check");
  await state("checking");
  await state("disarmed");
  await browser.click("#zero");
  await state("ready");
  await browser.hold("#arm", 1_500);
  await state("armed");
  await browser.click("#fly");
  await browser.until("!document.querySelector('#flights').hidden", 60_000);
  await stops();
  assert.deepEqual(browser.troubles, []);
}

async function beside() {
  const child = spawn(hostSim, ["monitor"], { stdio: ["ignore", "pipe", "inherit"] });
  monitor = child;
  await browser.open(await new Promise((go) => child.stdout.once("data", (line) => go(String(line).trim()))));
  await state("armed");
  await stops();
  await state("ready");
  await choose(browser, flown);
  await playsAndPauses(browser);
  await compare(browser, table(flown));
  await browser.click("#play-end");
  await state("ready");
  assert.deepEqual(browser.troubles, []);
}

try {
  await browser.begin();
  await alone();
  await beside();
  console.log("Firefox flies, stops, has these bits and plays a record beside a board");
} finally {
  monitor?.kill("SIGKILL");
  await browser.close();
}
