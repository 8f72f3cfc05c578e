// @ts-check
// The program that has served the page, asked over a socket: its board is at a line, or simulated there.
// Where the socket breaks, it is opened again as long as the page is there.

/** @typedef {import("./machine.js").Request} Request */
/** @typedef {import("./machine.js").Machine} Machine */

/** How long until a broken socket is opened again, in ms. */
const AGAIN = 1000;

/** @implements {Machine} */
export class Socket {
  constructor() {
    this.here = false;
    /** This page controls; others look on. */
    this.controls = false;
    /** Some page does. */
    this.controlled = false;
    /** @type {(rows: Float32Array) => void} */
    this.rows = () => {};
    /** Told when the socket opens or breaks, or somebody takes over. */
    this.changed = () => {};
    this.number = 0;
    /** @type {Map<number, { resolve: (answer: any) => void, reject: (why: Error) => void }>} */
    this.waiting = new Map();
    /** @type {WebSocket | undefined} */
    this.socket = undefined;
  }

  /** Ready when it is open for the first time. @returns {Promise<Socket>} */
  static open() {
    const socket = new Socket();
    return new Promise((opened) => socket.connect(() => opened(socket)));
  }

  get open() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** @param {() => void} opened */
  connect(opened) {
    const socket = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      this.socket = socket;
      opened();
      this.changed();
    });
    socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") this.take(JSON.parse(data));
      else this.rows(new Float32Array(data));
    });
    socket.addEventListener("close", () => {
      this.socket = undefined;
      this.controls = false;
      for (const { reject } of this.waiting.values()) reject(new Error("the program cannot be reached"));
      this.waiting.clear();
      this.changed();
      setTimeout(() => this.connect(opened), AGAIN);
    });
  }

  /** @param {any} told */
  take(told) {
    if (told.controls !== undefined) {
      this.controls = told.controls;
      this.controlled = told.controlled;
      this.changed();
      return;
    }
    const waiting = this.waiting.get(told.number);
    this.waiting.delete(told.number);
    if (told.error !== undefined) waiting?.reject(new Error(told.error));
    else waiting?.resolve(told.ok);
  }

  /** @param {Request} request @returns {Promise<any>} */
  ask(request) {
    return this.say({ request });
  }

  /** This page controls from now on. */
  takeOver() {
    return this.say({ take: true });
  }

  /** It controls no more, unless motors may turn. */
  lookAway() {
    return this.say({ look: true });
  }

  /** It controls again, unless another does. */
  async lookBack() {
    if (!this.controlled) await this.takeOver();
  }

  /** The program reads it, by a line of its own: stopping waits for no file. @param {File} file */
  async read(file) {
    const answer = await fetch("record", { method: "POST", body: file });
    if (!answer.ok) throw new Error((await answer.text()).trim());
    return new Float32Array(await answer.arrayBuffer());
  }

  /** @param {object} what @returns {Promise<any>} */
  say(what) {
    const { socket } = this;
    if (!socket || !this.open) return Promise.reject(new Error("the program cannot be reached"));
    this.number += 1;
    const { number } = this;
    socket.send(JSON.stringify({ number, ...what }));
    return new Promise((resolve, reject) => this.waiting.set(number, { resolve, reject }));
  }

  /** Time passes by itself. */
  pass() {}
}
