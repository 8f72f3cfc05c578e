// @ts-check
// A recorded flight, played as if it came now: Rust reads the file, and gives rows like a board's. Meanwhile
// the simulated board stands still.

import { button, byId, input } from "./dom.js";

/** How much is shown at once, in s: as much as the history keeps. */
const SHOWN = 60;

export class Player {
  /**
   * @param {import("./machine.js").Module} machine
   * @param {import("./history.js").History} samples
   * @param {import("./attempt.js").Attempt} attempt
   * @param {number} most bytes of a file
   * @param {() => void} changed another thing is drawn
   */
  constructor(machine, samples, attempt, most, changed) {
    this.machine = machine;
    this.samples = samples;
    this.most = most;
    this.changed = changed;
    /** @type {Float32Array | undefined} */
    this.rows = undefined;
    /** In s. */
    this.time = 0;
    const chosen = input("record");
    chosen.addEventListener("change", () =>
      attempt(async () => {
        await this.open(chosen.files?.[0]);
        chosen.value = "";
      }),
    );
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      attempt(() => this.open(event.dataTransfer?.files[0]));
    });
    input("play-at").addEventListener("input", () => this.seek(input("play-at").valueAsNumber));
    button("play-end").addEventListener("click", () => this.end());
  }

  /** @param {File | undefined} file */
  async open(file) {
    if (!file) return;
    const { size, name } = file;
    const { line } = this.machine;
    if (line) throw new Error("who plays a record does not see the board: leave the board first");
    if (size > this.most) throw new Error(`${name} has ${size} bytes; at most ${this.most} are read`);
    this.rows = this.machine.read(new Uint8Array(await file.arrayBuffer()));
    byId("play-name").textContent = name;
    input("play-at").max = `${this.start(this.rows.length / this.machine.columns - 1)}`;
    document.body.dataset.record = "yes";
    byId("play").hidden = false;
    this.seek(0);
  }

  end() {
    this.rows = undefined;
    delete document.body.dataset.record;
    byId("play").hidden = true;
    this.changed();
  }

  /** When a row was. @param {number} row */
  start(row) {
    return this.rows?.[row * this.machine.columns] ?? Infinity;
  }

  /** The first row after a time, as rows tell it. @param {number} time */
  after(time) {
    const told = Math.fround(time);
    let [low, high] = [0, (this.rows?.length ?? 0) / this.machine.columns];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.start(middle) > told) high = middle;
      else low = middle + 1;
    }
    return low;
  }

  /** @param {number} ticks */
  pass(ticks) {
    const [from, last] = [this.time, Number(input("play-at").max)];
    this.time = Math.min(from + ticks / 1000, last);
    this.give(from, this.time);
  }

  /** On from this time. @param {number} time in s */
  seek(time) {
    this.time = time;
    this.changed();
    this.give(time - SHOWN, time);
  }

  /** @param {number} from @param {number} to in s */
  give(from, to) {
    const [first, last] = [from, to].map((time) => this.after(time) * this.machine.columns);
    if (this.rows) this.samples.take(this.rows.subarray(first, last));
  }

  show() {
    byId("state").textContent = "a record";
    byId("state").dataset.state = "disarmed";
    for (const id of ["cause", "flying", "trial"]) byId(id).textContent = "";
    input("play-at").value = `${this.time}`;
  }
}
