// @ts-check
// The paper's flower pollination before the reader's eyes: flowers as dots in the space of the gains, the best
// response redrawn. What it finds is, bit for bit, what `host-sim tune` writes for that preset and seed.

import { button, byId, colour, download, input, select } from "./dom.js";
import { search } from "./search.js";

/**
 * @typedef {object} Progress
 * @property {number[][]} asked
 * @property {number[] | null} best
 * @property {number | null} cost
 * @property {number[]} at_bounds which gains of the best
 * @property {number} seconds that it computed
 * @property {number} evaluations
 * @property {number} budget
 * @property {{ time: number[], pitch: number[], yaw: number[] } | null} response
 * @property {string | null} gains_toml
 */

/** The goal of the paper's step, drawn as a line. */
const SECONDS = 5;

export class Tuner {
  /**
   * @param {import("./machine.js").Machine} machine
   * @param {Uint8Array | undefined} bytes of the module, if it is here, for a thread of its own
   * @param {string} source of that thread @param {any} about
   * @param {(gains: string) => void} use takes what was found into the sliders
   */
  constructor(machine, bytes, source, about, use) {
    this.machine = machine;
    this.bytes = bytes;
    this.source = URL.createObjectURL(new Blob([source], { type: "text/javascript" }));
    this.about = about;
    /** @type {Worker | undefined} */
    this.worker = undefined;
    /** Counts searches. */
    this.run = 0;
    /** @type {number[][]} */
    this.flowers = [];
    /** @type {number[]} */
    this.best = [];
    /** @type {number | undefined} */
    this.drawing = undefined;
    /** @type {Progress["response"]} */
    this.response = null;
    /** @type {string | null} */
    this.found = null;
    button("tune").addEventListener("click", () => this.start());
    button("tune-use").addEventListener("click", () => this.found && use(this.found));
    button("tune-save").addEventListener("click", () => this.found && download("gains.toml", [this.found]));
  }

  start() {
    this.worker?.terminate();
    this.flowers = [];
    this.response = null;
    this.found = null;
    for (const id of ["tune-use", "tune-save"]) button(id).disabled = true;
    this.run += 1;
    const { run } = this;
    const seed = Math.max(0, Math.round(input("seed").valueAsNumber || 0));
    const preset = select("preset").value;
    if (!this.bytes) {
      const tell = (/** @type {Progress} */ progress) => {
        if (run === this.run) this.take(progress);
        return run === this.run;
      };
      search(this.machine, { preset, seed }, tell).catch((error) => this.take({ error: error.message }));
      return;
    }
    const worker = new Worker(this.source);
    this.worker = worker;
    worker.addEventListener("message", (event) => this.take(event.data));
    worker.postMessage({ bytes: this.bytes, preset, seed });
  }

  /** @param {Progress | { error: string }} progress */
  take(progress) {
    if ("error" in progress) {
      byId("tune-told").textContent = progress.error;
      return;
    }
    this.flowers.push(...progress.asked);
    this.response = progress.response ?? this.response;
    const cost = progress.cost === null ? "none flies yet" : `ISE ${progress.cost.toFixed(6)}`;
    byId("tune-told").textContent =
      `${progress.evaluations} of ${progress.budget} evaluations, ${cost}, ${progress.seconds.toFixed(1)} s`;
    const best = progress.best ?? [];
    this.best = best;
    byId("tune-best").textContent = best
      .map((gain, k) => {
        const held = progress.at_bounds.includes(k) ? " (at its bound)" : "";
        return `${this.about.gains[k]} ${gain.toFixed(3)}${held}`;
      })
      .join(", ");
    if (progress.gains_toml) {
      this.found = progress.gains_toml;
      byId("tune-told").dataset.gains = progress.gains_toml;
      for (const id of ["tune-use", "tune-save"]) button(id).disabled = false;
    }
    // Once a frame, however fast it searches.
    if (this.drawing === undefined) this.drawing = requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.drawing = undefined;
    this.gains("tune-pitch", 0, this.best);
    this.gains("tune-yaw", 2, this.best);
    this.curve();
  }

  /**
   * Flowers of one axis: its two gains across and up.
   * @param {string} id @param {number} first @param {number[]} best
   */
  gains(id, first, best) {
    const draw = canvas(id);
    if (!draw) return;
    const { context, width, height } = draw;
    const [low, high] = this.about.bounds;
    const x = (/** @type {number} */ gain) => 6 + ((gain - low) / (high - low)) * (width - 12);
    const y = (/** @type {number} */ gain) => height - 6 - ((gain - low) / (high - low)) * (height - 12);
    const dot = (/** @type {number[]} */ at, /** @type {number} */ radius) => {
      context.beginPath();
      context.arc(x(at[first]), y(at[first + 1]), radius, 0, 2 * Math.PI);
      context.fill();
    };
    context.fillStyle = colour("text");
    context.globalAlpha = 0.35;
    for (const flower of this.flowers) dot(flower, 1.6);
    context.globalAlpha = 1;
    context.fillStyle = colour("pitch");
    for (const flower of this.flowers.slice(-50)) dot(flower, 2.2);
    context.fillStyle = colour("stop");
    if (best.length > 0) dot(best, 5);
  }

  curve() {
    const draw = canvas("tune-response");
    if (!draw || !this.response) return;
    const { context, width, height } = draw;
    const { time, pitch, yaw } = this.response;
    const most = Math.max(...pitch, ...yaw, 1);
    const line = (
      /** @type {number[]} */ angles,
      /** @type {string} */ tint,
      /** @type {number[]} */ dash,
    ) => {
      context.strokeStyle = colour(tint);
      context.lineWidth = 1.8;
      context.setLineDash(dash);
      context.beginPath();
      angles.forEach((angle, k) => {
        context.lineTo((time[k] / SECONDS) * width, height - 4 - (angle / most) * (height - 8));
      });
      context.stroke();
    };
    line(pitch, "pitch", []);
    line(yaw, "yaw", [7, 4]);
  }
}

/** An empty canvas, as sharp as the screen. @param {string} id */
function canvas(id) {
  const element = /** @type {HTMLCanvasElement} */ (byId(id));
  const [width, height] = [element.clientWidth, element.clientHeight];
  const scale = Math.min(devicePixelRatio, 2);
  [element.width, element.height] = [width * scale, height * scale];
  const context = element.getContext("2d");
  if (!context) return undefined;
  context.scale(scale, scale);
  return { context, width, height };
}
