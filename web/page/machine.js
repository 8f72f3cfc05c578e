// @ts-check
// What computes: the WebAssembly module of web/, which holds board, rig, client and tuner. Everything that the
// page knows it has asked here.

/**
 * @typedef {object} Exports
 * @property {WebAssembly.Memory} memory
 * @property {(length: number) => number} input
 * @property {() => number} ask
 * @property {() => number} output
 * @property {(ticks: number) => number} advance
 * @property {() => number} samples
 */

/**
 * A request as `web/src/request.rs` reads it: a name, or an object of one.
 * @typedef {string | object} Request
 */

const encoder = new TextEncoder();
const decoder = new TextDecoder();

export class Machine {
  /** @param {Exports} exports */
  constructor(exports) {
    this.exports = exports;
    /** Numbers in a row of samples; `about` tells. */
    this.columns = 0;
  }

  /** @param {BufferSource} bytes */
  static async load(bytes) {
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Machine(/** @type {any} */ (instance.exports));
  }

  /**
   * Asks, and gives the answer; throws what is wrong, in words.
   * @param {Request} request
   * @returns {any}
   */
  ask(request) {
    const { memory, input, ask, output } = this.exports;
    const question = encoder.encode(JSON.stringify(request));
    const at = input(question.length);
    new Uint8Array(memory.buffer, at, question.length).set(question);
    const length = ask();
    const answer = JSON.parse(decoder.decode(new Uint8Array(memory.buffer, output(), length)));
    if (answer.error !== undefined) throw new Error(answer.error);
    return answer.ok;
  }

  /**
   * Lets simulated time pass. The rows are valid until the next call.
   * @param {number} ticks
   * @returns {Float32Array}
   */
  advance(ticks) {
    const { memory, advance, samples } = this.exports;
    const rows = advance(ticks);
    return new Float32Array(memory.buffer, samples(), rows * this.columns);
  }
}
