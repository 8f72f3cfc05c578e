// @ts-check
// `host-sim monitor` in a headless Chromium: a rig flies there at once; the page stops it by key, by being
// hidden and by being frozen; a minute of samples comes whole, and the page keeps up with it.
//
//     node web/tests/monitor.mjs HOST-SIM [SECONDS] [SCREENSHOTS]

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { Chromium } from "./chromium.mjs";
import { delayOfStop } from "./stop.mjs";

const [hostSim, seconds = "60", screenshots] = process.argv.slice(2);

const begun = Date.now();
const browser = await Chromium.start();
const monitor = spawn(hostSim, ["monitor"], { stdio: ["ignore", "pipe", "inherit"] });

/** @param {string} name @param {() => Promise<void>} work */
async function step(name, work) {
  const from = Date.now();
  await work();
  console.log(`  ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
}

const rest = (/** @type {number} */ ms) => new Promise((go) => setTimeout(go, ms));
const ask = (/** @type {unknown} */ request) =>
  browser.value(`window.twinrotor.machine.ask(${JSON.stringify(request)})`);
const status = () => ask({ status: { since: 0 } });
const state = (/** @type {string} */ wanted, most = 20_000) =>
  browser.until(`document.querySelector("#state").textContent === "${wanted}"`, most);

/** Arms it as a person does, unless it is, and waits until it pushes. */
async function arm() {
  if ((await status()).state === "armed") return;
  await browser.until("!document.querySelector('#arm').disabled", 20_000);
  await browser.hold("#arm", 1_500);
  await state("armed");
  await browser.until("Math.abs(window.twinrotor.samples.row().main_volts) > 1", 20_000);
}

/** The browser and all that it has started. @returns {number[]} */
function processes() {
  const parents = new Map();
  for (const name of readdirSync("/proc").filter((entry) => /^\d+$/.test(entry))) {
    try {
      const told = readFileSync(`/proc/${name}/stat`, "utf8");
      parents.set(Number(name), Number(told.slice(told.lastIndexOf(")") + 2).split(" ")[1]));
    } catch {
      // It has ended meanwhile.
    }
  }
  const own = [browser.id];
  for (const parent of own)
    for (const [child, its] of parents) if (its === parent && !own.includes(child)) own.push(child);
  return own;
}

/** @returns {Promise<string>} */
const url = new Promise((go) => monitor.stdout.once("data", (line) => go(String(line).trim())));

async function shot(
  /** @type {string} */ name,
  /** @type {number} */ width,
  /** @type {number} */ height,
) {
  if (!screenshots) return;
  mkdirSync(screenshots, { recursive: true });
  await browser.size(width, height, false);
  writeFileSync(join(screenshots, name), await browser.screenshot());
}

/**
 * In the page: how long ago the board said the newest row of those just drawn, in ms, sorted; for so many ms
 * the plots are drawn 30 times a second. When a browser shows what is drawn is its own affair.
 * @param {number} lasts
 */
async function delaysToPixel(lasts) {
  const { machine, plots, samples } = /** @type {any} */ (window).twinrotor;
  // The board's clock against the page's: of many questions the one that was answered soonest.
  let [soonest, ahead] = [Infinity, 0];
  for (let k = 0; k < 50; k += 1) {
    const from = performance.now();
    const { time } = await machine.ask({ status: { since: 1e9 } });
    const took = performance.now() - from;
    if (took < soonest) [soonest, ahead] = [took, time * 1000 - (from + took / 2)];
  }
  /** @type {number[]} */
  const delays = [];
  for (const end = performance.now() + lasts; performance.now() < end; ) {
    await new Promise((go) => setTimeout(go, 30));
    plots.draw();
    delays.push(performance.now() - (samples.row().time * 1000 - ahead));
  }
  return delays.sort((a, b) => a - b);
}

async function journey() {
  await step("a rig flies there", async () => {
    await browser.open(await url);
    await state("armed");
    assert.equal((await status()).simulated, true);
  });
  await step(`${seconds} s of samples come whole, and the page keeps up`, async () => {
    // Of garbage and of the heap the standard knows nothing.
    await browser.cdp("HeapProfiler.enable");
    await browser.cdp("HeapProfiler.collectGarbage");
    await browser.cdp("Performance.enable");
    const metrics = async () => {
      const told = (await browser.cdp("Performance.getMetrics")).metrics;
      return Object.fromEntries(told.map((/** @type {any} */ one) => [one.name, one.value]));
    };
    await browser.value(`(() => {
      window.seen = { rows: 0, lost: 0, frames: 0, last: undefined };
      const { machine } = window.twinrotor, take = machine.rows;
      machine.rows = (rows) => {
        const width = rows.length && window.twinrotor.samples.names.length;
        for (let k = 0; k < rows.length; k += width) {
          if (seen.last !== undefined && rows[k] - seen.last > 0.0075) seen.lost += 1;
          seen.last = rows[k];
          seen.rows += 1;
        }
        take(rows);
      };
      const frame = () => {
        seen.frames += 1;
        requestAnimationFrame(frame);
      };
      requestAnimationFrame(frame);
    })()`);
    const before = await metrics();
    for (let second = 0; second < Number(seconds); second += 5) {
      await rest(5_000);
      await ask({ aim: { pitch_deg: second % 2 ? 5 : 0, yaw_deg: second % 20 } }).catch(() => {});
    }
    await browser.cdp("HeapProfiler.collectGarbage");
    const after = await metrics();
    const seen = await browser.value("window.seen");
    // Drawn again and again, so that a machine that draws two frames a second has compiled it, too; one that
    // is busy stops in the midst of most: the quickest fifth tells what it takes.
    const script = await browser.value(`(async () => {
      const took = [];
      for (let k = 0; k < 200; k += 1) {
        const from = performance.now();
        window.twinrotor.plots.draw();
        await undefined;
        took.push(performance.now() - from);
      }
      return took.sort((a, b) => a - b)[40];
    })()`);
    const grown = (after.JSHeapUsedSize - before.JSHeapUsedSize) / 1e6;
    console.log(
      `    ${seen.rows} rows, ${seen.lost} gaps, ${seen.frames} frames, ` +
        `${script.toFixed(1)} ms of script a frame, heap ${grown.toFixed(1)} MB more`,
    );
    assert.equal(seen.lost, 0);
    assert.ok(seen.rows > 195 * Number(seconds), `${seen.rows} rows`);
    assert.ok(script < 8, `${script} ms a frame`);
    assert.ok(grown < 4, `${grown} MB`);
  });
  await step("what the board says is drawn within 100 ms, 95 times of 100", async () => {
    // A machine that is busy with other things keeps the browser waiting: one quiet spell of three tells.
    let late = Infinity;
    for (let spell = 0; spell < 3 && late >= 100; spell += 1) {
      const delays = await browser.value(`(${delaysToPixel})(10_000)`);
      const at = (/** @type {number} */ share) => delays[Math.floor(share * (delays.length - 1))];
      const level = await browser.value("window.twinrotor.pace.at");
      late = at(0.95);
      console.log(
        `    ${delays.length} times; median ${at(0.5).toFixed(0)} ms, 95 % ${late.toFixed(0)} ms, ` +
          `${level} steps less drawn`,
      );
    }
    assert.ok(late < 100, `${late} ms`);
  });
  await shot("monitor.png", 1280, 800);
  await shot("monitor-phone.png", 390, 844);
  await step("stops within 100 ms of the key, by Space and by Esc", async () => {
    for (const key of [" ", "Escape"]) {
      // To have measured a page, or to have made its picture, may have kept it from saying that it is there.
      await arm();
      const delay = await delayOfStop(browser, key);
      console.log(`    ${JSON.stringify(key)}: ${delay.toFixed(0)} ms`);
      assert.ok(delay < 100, `${JSON.stringify(key)}: ${delay} ms`);
    }
    await state("ready");
    await arm();
  });
  await step("a page that is hidden switches the motors off at once", async () => {
    const from = (await status()).time;
    // A headless browser shows every page: the page is told that it is hidden as a browser tells it.
    await browser.value(`(() => {
      Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
      document.dispatchEvent(new Event("visibilitychange"));
      delete document.visibilityState;
    })()`);
    await state("ready");
    const off = (await status()).journal.filter((/** @type {any} */ entry) => entry.words === "ready").at(-1);
    assert.ok(off.time - from < 1, `${off.time - from} s`);
    await arm();
  });
  await step("another page takes over and goes: the page says who controls", async () => {
    const told = (/** @type {string} */ words) =>
      browser.until(
        `[...document.querySelectorAll("#control:not([hidden])")].some((one) =>
          one.innerText.includes("${words}"))`,
        5_000,
      );
    await browser.value(`(() => {
      window.other = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
      other.onopen = () => other.send(JSON.stringify({ number: 1, take: true }));
    })()`);
    await told("another page controls");
    await browser.value("other.close()");
    await told("nobody controls this board");
    await browser.click("#take");
    await browser.until("document.querySelector('#control').hidden", 5_000);
    await arm();
  });
  await step("draws less on a machine that is late, and all again on one that is quick", async () => {
    const levels = await browser.value(`(() => {
      const mine = new window.twinrotor.pace.constructor(), levels = [];
      let now = 0;
      const fly = (seconds, interval) => {
        for (const end = now + 1000 * seconds; now < end; now += interval) mine.frame(now);
        levels.push(mine.at);
      };
      for (const [seconds, interval] of [[10, 17], [10, 150], [10, 33], [60, 17]]) fly(seconds, interval);
      return levels;
    })()`);
    assert.deepEqual(levels, [0, 4, 4, 0]);
  });
  await step("tunes without a module of its own", async () => {
    await browser.value("document.querySelector('#search').open = true");
    await browser.click("#tune");
    await browser.until("document.querySelector('#tune-told').dataset.gains !== undefined", 60_000);
    await browser.value("document.querySelector('#search').open = false");
  });
  // Last: a browser that was stopped draws hardly any more.
  await step("a browser that is stopped is missed within 1.5 s", async () => {
    const { time } = await status();
    const all = processes();
    for (const id of all) process.kill(id, "SIGSTOP");
    await rest(2_500);
    for (const id of all) process.kill(id, "SIGCONT");
    await state("ready");
    const { journal } = await status();
    const missed = journal.find((/** @type {any} */ entry) => /not heard for more than/.test(entry.words));
    assert.ok(missed.time - time < 1.5, `${missed.time - time} s`);
    await arm();
  });
  await step("says that the program has ended, which had switched the motors off", async () => {
    const ended = new Promise((go) => monitor.once("exit", go));
    monitor.kill("SIGINT");
    assert.equal(await ended, 130);
    const told = "document.querySelector('#control-told').textContent";
    await browser.until(`${told}.includes('host-sim monitor')`, 5_000);
  });
  const troubles = (await browser.troubles()).filter((trouble) => !/WebSocket connection/.test(trouble));
  assert.deepEqual(troubles, []);
  const own = new URL(await url).host;
  const asked = await browser.requests();
  const outside = asked.filter((one) => !/^(data|blob):/.test(one) && new URL(one).host !== own);
  assert.deepEqual(outside, []);
}

try {
  await journey();
  console.log(`the served page passed in ${((Date.now() - begun) / 1000).toFixed(0)} s`);
} finally {
  monitor.kill("SIGKILL");
  await browser.close();
}
