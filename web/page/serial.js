// @ts-check
// A board at a port of this computer, by Web Serial: bytes go between the port and the desk, whose board is
// at a line then. Whoever does not see the board does not fly it: a page that is hidden or closed switches
// the motors off first, as `control.js` does; a browser that hangs the board itself misses.

import { button, byId } from "./dom.js";

/** @typedef {import("./types.js").Port} Port */

/** From one word to the board to the next where it says nothing itself, in ms. */
const EVERY = 10;
/** How long it may take until the motors are seen to be off, in ms. */
const SEEN = 500;
const NOTHING = new Uint8Array();
const COMMAND = "run host-sim monitor --port auto and open the address that it prints";

/** @param {unknown} error */
const words = (error) => (error instanceof Error ? error.message : String(error)).replace(/\.$/, "");

export class Serial {
  /**
   * @param {import("./machine.js").Module} machine
   * @param {number} baudRate
   * @param {import("./attempt.js").Attempt} attempt
   * @param {() => void} stop switches the motors off
   * @param {() => Promise<void>} simulated begins with the simulated board again
   */
  constructor(machine, baudRate, attempt, stop, simulated) {
    this.machine = machine;
    this.baudRate = baudRate;
    this.stop = stop;
    this.simulated = simulated;
    /** In ms. */
    this.now = () => performance.now();
    this.begun = 0;
    /** The port, as long as there is a board at it. @type {Port | undefined} */
    this.port = undefined;
    /** @type {WritableStreamDefaultWriter<Uint8Array> | undefined} */
    this.writer = undefined;
    /** @type {ReadableStreamDefaultReader<Uint8Array> | undefined} */
    this.reader = undefined;
    this.reading = Promise.resolve();
    button("connect").addEventListener("click", () => attempt(() => this.connect()));
    button("leave").addEventListener("click", () => attempt(() => this.leave()));
    const unseen = () => this.port && stop();
    document.addEventListener("visibilitychange", () => document.visibilityState === "hidden" && unseen());
    window.addEventListener("pagehide", unseen);
    byId("line").hidden = false;
    this.show();
  }

  /** To the port that a person chooses. */
  async connect() {
    const { serial } = navigator;
    if (!serial) return;
    const port = await serial.requestPort().catch((/** @type {unknown} */ error) => {
      throw new Error(`no port: ${words(error)}`);
    });
    await port.open({ baudRate: this.baudRate, bufferSize: 65_536 }).catch((/** @type {unknown} */ error) => {
      throw new Error(`${words(error)}: is it plugged in, and does no other program have it?`);
    });
    await this.machine.ask({ line: "opened" });
    this.begun = this.now();
    this.port = port;
    this.writer = port.writable?.getWriter();
    if (!this.machine.line) setInterval(() => this.machine.line?.(), EVERY);
    this.machine.line = () => this.turn(NOTHING);
    this.reading = this.read(port);
    this.show();
  }

  /** @param {Uint8Array} came */
  turn(came) {
    const { port, writer } = this;
    // Where the port is lost, time goes on all the same.
    const said = this.machine.exchange(came, this.now() - this.begun);
    if (port && writer && said.length > 0) writer.write(said).catch((error) => this.lost(port, words(error)));
  }

  /** Until it is lost. An error that leaves the port open begins a new stream. @param {Port} port */
  async read(port) {
    let why = "the port gives nothing any more";
    /** @type {ReadableStream<Uint8Array> | null} */
    let stream = null;
    while (this.port === port && port.readable && port.readable !== stream) {
      stream = port.readable;
      const reader = stream.getReader();
      this.reader = reader;
      try {
        for (;;) {
          const { value, done } = await reader.read();
          if (done) break;
          if (this.port === port) this.turn(value);
        }
      } catch (error) {
        why = words(error);
      }
      reader.releaseLock();
    }
    this.lost(port, why);
  }

  /** @param {Port} port @param {string} why */
  lost(port, why) {
    if (this.port !== port) return;
    this.port = undefined;
    this.machine.ask({ line: { lost: why } });
    this.close(port).catch(() => {});
    this.show();
  }

  /** @param {Port} port */
  async close(port) {
    const { reader, writer, reading } = this;
    await reader?.cancel().catch(() => {});
    await reading;
    writer?.releaseLock();
    await port.close();
  }

  /** Motors off, then back to the simulated board. */
  async leave() {
    const { machine, port } = this;
    const seen = !port || (await this.off());
    this.port = undefined;
    machine.line = undefined;
    this.show();
    await machine.ask({ line: "closed" });
    await this.simulated();
    await (port && this.close(port).catch(() => {}));
    if (!seen) throw new Error("the port was closed, and that the motors are off was not seen");
  }

  /** Whether the motors are seen to be off. */
  async off() {
    this.stop();
    const until = performance.now() + SEEN;
    for (;;) {
      const { state, silent } = await this.machine.ask({ status: { since: 0 } });
      if (!silent && state !== "armed" && state !== "checking") return true;
      if (performance.now() > until) return false;
      await new Promise((go) => setTimeout(go, EVERY));
    }
  }

  show() {
    const { machine, port } = this;
    const [line, able] = [machine.line !== undefined, navigator.serial !== undefined];
    machine.here = !line;
    document.body.dataset.way = line ? "there" : "here";
    button("connect").hidden = port !== undefined;
    button("connect").disabled = !able;
    button("leave").hidden = !line;
    const lacks = isSecureContext
      ? "This browser has no Web Serial (Chrome, Edge and Firefox since 151 have it)"
      : "A browser lets only pages of a file, of this computer or by https have a port";
    byId("line-told").textContent = able ? "" : `${lacks}: ${COMMAND}.`;
  }
}
