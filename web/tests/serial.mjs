// @ts-check
// The page with a board at a serial port, in a headless Chromium: the port is a JavaScript object as Web
// Serial has them, at whose other end a second module serves its simulated board.
//
//     node web/tests/serial.mjs heli.html

import assert from "node:assert/strict";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium } from "./chromium.mjs";

const page = pathToFileURL(resolve(process.argv[2])).href;
const browser = await Chromium.start();
const begun = Date.now();

/** @param {string} name @param {() => Promise<void>} work */
async function step(name, work) {
  const from = Date.now();
  await work();
  console.log(`  ${name} (${((Date.now() - from) / 1000).toFixed(1)} s)`);
}

/**
 * In the page: a port with a board. Time is the board's, and passes when the test lets it, ten ticks at a
 * time: a machine that is busy with other things flies no worse.
 */
const inject = `(async () => {
  const { machine, serial, bytes } = window.twinrotor;
  const other = await machine.constructor.load(bytes);
  other.answer({ begin: { preset: "aero", controller: "own" } });
  const port = { readable: null, writable: null, busy: false, options: undefined, said: [], closed: 0 };
  let give, time = 0, deaf = 0;
  const stream = () => new ReadableStream({ start: (controller) => { give = controller; } });
  port.open = async (options) => {
    if (port.busy) throw new DOMException("Failed to open serial port.", "NetworkError");
    Object.assign(port, { options, readable: stream() });
    port.writable = new WritableStream({ write: (chunk) => { port.said.push(...chunk); } });
  };
  port.close = async () => {
    if (port.readable?.locked || port.writable?.locked) throw new TypeError("locked");
    Object.assign(port, { readable: null, writable: null, closed: port.closed + 1 });
  };
  port.unplug = () => {
    port.readable = null;
    give.error(new DOMException("The device has been lost.", "NetworkError"));
  };
  port.garble = () => {
    const broken = give;
    port.readable = stream();
    broken.error(new DOMException("Framing error", "FramingError"));
  };
  const turn = new MessageChannel();
  const next = () => new Promise((go) => { turn.port1.onmessage = go; turn.port2.postMessage(0); });
  // Until it is so, or so many milliseconds of the board have passed; how many did.
  window.flyOn = async (most, done) => {
    const from = time;
    while (time < from + most && !(await done())) {
      other.put(Uint8Array.from(port.said.splice(0)));
      const came = other.got(other.exports.serve(10)).slice();
      time += 10;
      if (port.readable && came.length > 0) give.enqueue(came);
      // Where nothing comes the page's own clock goes on, which the board's may outrun.
      if (!port.readable) machine.line?.();
      await next();
    }
    return (await done()) ? time - from : -1;
  };
  window.desk = () => machine.answer({ status: { since: 0 } });
  serial.now = () => time;
  window.port = port;
  Object.defineProperty(navigator, "serial", { value: { requestPort: async () => {
    if (window.refused) throw new DOMException("No port selected by the user.", "NotFoundError");
    return port;
  } }, configurable: true });
  serial.show();
})()`;

/** Lets the board's time pass. @param {string} so @param {number} most in ms */
async function until(so, most) {
  const took = await browser.value(`flyOn(${most}, () => (${so}))`);
  const what = async () => JSON.stringify(await browser.value("desk()"));
  assert.ok(took >= 0, `${so}: ${took < 0 ? await what() : ""}`);
  return took;
}

/** The same until the board is so; the page shows it, and what it shows moves no more. */
async function state(/** @type {string} */ wanted, most = 2_000) {
  const took = await until(`desk().state === "${wanted}"`, most);
  await browser.until(`document.querySelector("#state").textContent === "${wanted}"`, 10_000);
  return took;
}
const text = (/** @type {string} */ id) => browser.value(`document.querySelector("#${id}").textContent`);
const told = (/** @type {string} */ id, /** @type {RegExp} */ words) =>
  browser.until(`${words}.test(document.querySelector("#${id}").textContent)`, 10_000);
const enabled = (/** @type {string} */ id) =>
  browser.until(`document.querySelector("#${id}:enabled:not([hidden])") !== null`, 10_000);

async function arm() {
  await enabled("arm");
  await browser.hold("#arm", 1_500);
  await state("armed");
  await until("Math.abs(window.twinrotor.samples.row().main_volts) > 1", 5_000);
}

async function connect() {
  await browser.click("#connect");
  await until("desk().simulated === false && desk().firmware !== null", 3_000);
  await browser.until("document.body.dataset.rig === 'real'", 10_000);
}

async function journey() {
  await step("where there is no Web Serial it says so, and what to run", async () => {
    await browser.open(page);
    const source = "delete Navigator.prototype.serial";
    // Before the page's own scripts: what the standard lacks.
    const { identifier } = await browser.cdp("Page.addScriptToEvaluateOnNewDocument", { source });
    await browser.open(`${page}?lacks`);
    assert.match(await text("line-told"), /no Web Serial.*host-sim monitor --port auto/);
    assert.equal(await browser.value("document.querySelector('#connect').disabled"), true);
    await browser.cdp("Page.removeScriptToEvaluateOnNewDocument", { identifier });
    await browser.open(`${page}?has`);
  });
  await step("a port that is not chosen, or busy, is told in a sentence", async () => {
    await browser.value(inject);
    assert.equal(await text("line-told"), "");
    await browser.value("window.refused = true");
    await browser.click("#connect");
    await told("told", /^no port: No port selected by the user$/);
    await browser.run("window.refused = false; port.busy = true");
    await browser.click("#connect");
    await told("told", /Failed to open serial port: is it plugged in, and does no other program have it\?/);
    assert.equal(await browser.value("desk().simulated"), true);
    await browser.value("port.busy = false");
  });
  await step("a board at a port is checked and zeroed", async () => {
    await connect();
    assert.equal(await browser.value("port.options.baudRate"), 1_000_000);
    await until("desk().next === 'check'", 2_000);
    await enabled("check");
    await browser.click("#check");
    await state("checking");
    await until("desk().next === 'zero'", 120_000);
    await enabled("zero");
    await browser.click("#zero");
    await state("ready", 61_000);
    // Who plays a record would not see the board.
    await browser.run(`const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File(["t,pitch,yaw\\n0,0,0\\n"], "a.csv"));
      document.body.dispatchEvent(
        new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));`);
    await told("told", /leave the board first/);
    assert.equal(await browser.value("document.querySelector('#play').hidden"), true);
    // Nothing of a simulated rig is offered.
    assert.equal(await browser.value("document.querySelector('#faults').checkVisibility()"), false);
    assert.equal(await browser.value("document.querySelector('#speed').checkVisibility()"), false);
  });
  await step("it is armed and flies a step, with its numbers", async () => {
    await arm();
    await enabled("fly");
    await browser.click("#fly");
    await until("desk().flights === 1", 60_000);
    await told("flight-numbers", /ISE, pitch/);
  });
  await step("stops within 100 ms of the key, also where the line damages a word", async () => {
    for (const garbled of [false, true]) {
      if ((await browser.value("desk().state")) !== "armed") await arm();
      if (garbled) await browser.value("port.garble()");
      await browser.key("Escape");
      if (garbled) await browser.value("void port.said.splice(0)");
      const off = "(({ main_volts, tail_volts }) => main_volts === 0 && tail_volts === 0)";
      const took = await until(`${off}(window.twinrotor.samples.row())`, 1_000);
      assert.ok(took <= 100, `${took} ms`);
      await state("ready");
    }
  });
  await step("a page that is hidden, or closed, switches the motors off at once", async () => {
    for (const leave of [
      `Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
       document.dispatchEvent(new Event("visibilitychange"));
       delete document.visibilityState;`,
      'window.dispatchEvent(new Event("pagehide"));',
    ]) {
      await arm();
      await browser.run(leave);
      assert.ok((await state("ready")) <= 100);
    }
  });
  await step("a board that is unplugged is told, and that its motors were not seen off", async () => {
    await arm();
    await browser.value("port.unplug()");
    await told("cause", /device has been lost; that its motors are off was not seen; look at its plug/);
    await until("desk().silent", 1_000);
    await told("state", /no answer/);
    // Nobody is heard any more: the board has switched them off, and says so when it is there again.
    await until("false", 3_000).catch(() => {});
    await connect();
    await until("desk().state !== 'connecting'", 2_000);
    assert.notEqual(await browser.value("desk().state"), "armed");
  });
  await step("is left with the motors off, for the simulated board", async () => {
    await until("desk().steps.clear === null || desk().state === 'ready'", 5_000);
    if ((await browser.value("desk().state")) === "fault") {
      await enabled("clear");
      await browser.click("#clear");
      await state("ready", 5_000);
    }
    await arm();
    await browser.click("#leave");
    await until("!window.twinrotor.machine.line", 2_000);
    await browser.until("desk().simulated && port.closed === 2", 10_000);
    assert.equal(await text("told"), "");
    await browser.until("!document.querySelector('#check').disabled", 10_000);
  });
  assert.deepEqual(await browser.troubles(), []);
}

try {
  await journey();
  console.log(`a board at a serial port passed in ${((Date.now() - begun) / 1000).toFixed(0)} s`);
} finally {
  await browser.close();
}
