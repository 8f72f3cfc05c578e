// @ts-check
// What computes in the page itself: the WebAssembly module of web/, which holds board, rig, client and tuner.
// Where a program has served the page, `socket.js` asks the same of it. Everything that the page knows it has
// asked of one of them.

/**
 * @typedef {object} Exports
 * @property {WebAssembly.Memory} memory
 * @property {(length: number) => number} input
 * @property {() => number} ask
 * @property {() => number} output
 * @property {(ticks: number) => number} advance
 * @property {() => number} samples
 * @property {(now: number) => number} exchange
 * @property {() => number} rows
 * @property {() => number} open
 * @property {() => number} record
 */

/**
 * A request as `web/src/request.rs` reads it: a name, or an object of one.
 * @typedef {string | object} Request
 */

/**
 * Whom the page asks: here, or over a socket.
 * @typedef {object} Machine
 * @property {(request: Request) => Promise<any>} ask gives the answer, or throws what is wrong, in words
 * @property {(ticks: number) => void} pass lets simulated time pass, where it is the page's
 * @property {(rows: Float32Array) => void} rows takes rows of samples; set by whoever wants them
 * @property {(file: File) => Promise<Float32Array>} read gives rows out of a recorded flight
 * @property {() => Promise<void>} lookAway something else than the board is shown from now on, if that may be
 * @property {() => Promise<void>} lookBack the board is shown again
 * @property {boolean} here its board is simulated in the page
 */

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** @implements {Machine} */
export class Module {
  /** @param {Exports} exports */
  constructor(exports) {
    this.exports = exports;
    this.here = true;
    /** Its board is at a line: carries bytes there and back, now. @type {(() => void) | undefined} */
    this.line = undefined;
    /** Numbers in a row of samples. */
    this.columns = this.answer("about").columns.length;
    /** @type {(rows: Float32Array) => void} */
    this.rows = () => {};
  }

  /** @param {BufferSource} bytes */
  static async load(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Module(/** @type {any} */ (instance.exports));
  }

  /**
   * What was asked is done when this returns, whenever the answer is read.
   * @param {Request} request
   */
  ask(request) {
    try {
      return Promise.resolve(this.answer(request));
    } catch (error) {
      return Promise.reject(error);
    }
  }

  /** @param {Request} request @returns {any} */
  answer(request) {
    this.put(encoder.encode(JSON.stringify(request)));
    return this.answered(this.exports.ask());
  }

  /** @param {number} length @returns {any} */
  answered(length) {
    const answer = JSON.parse(decoder.decode(this.got(length)));
    if (answer.error !== undefined) throw new Error(answer.error);
    return answer.ok;
  }

  /** @param {Uint8Array} bytes */
  put(bytes) {
    const { memory, input } = this.exports;
    const at = input(bytes.length);
    new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
  }

  /** @param {number} length */
  got(length) {
    return new Uint8Array(this.exports.memory.buffer, this.exports.output(), length);
  }

  /** @param {File} file */
  async read(file) {
    this.put(new Uint8Array(await file.arrayBuffer()));
    const numbers = this.answered(this.exports.open());
    return new Float32Array(this.exports.memory.buffer, this.exports.record(), numbers).slice();
  }

  async lookAway() {
    if (this.line) throw new Error("who plays a record does not see the board: leave the board first");
  }

  async lookBack() {}

  /** @param {number} ticks */
  pass(ticks) {
    if (this.line) this.line();
    else this.tell(this.exports.advance(ticks));
  }

  /** What is to be said over a line to what came. @param {Uint8Array} came @param {number} now in ms */
  exchange(came, now) {
    this.put(came);
    const said = this.got(this.exports.exchange(now)).slice();
    this.tell(this.exports.rows());
    return said;
  }

  /** @param {number} rows */
  tell(rows) {
    const { memory, samples } = this.exports;
    this.rows(new Float32Array(memory.buffer, samples(), rows * this.columns));
  }
}
