// @ts-check
// A recorded flight, played as if it came now: Rust reads the file, and gives rows like a board's. Meanwhile
// a board that is simulated in the page stands still; one that a program has goes on, and what it says is
// kept. Whoever plays a record does not see the board, so this page flies none until the record is closed;
// what stops the motors stops them.

import { button, byId, input } from "./dom.js";
import { History } from "./history.js";

/** How much is shown at once, in s: as much as the history keeps. */
const SHOWN = 60;

export class Player {
  /**
   * @param {import("./machine.js").Machine} machine
   * @param {string[]} names of the columns
   * @param {import("./plots.js").Plots} plots
   * @param {import("./attempt.js").Attempt} attempt
   * @param {number} most bytes of a file
   * @param {(record?: History) => void} draw this from now on, or the board again
   */
  constructor(machine, names, plots, attempt, most, draw) {
    this.machine = machine;
    this.plots = plots;
    this.attempt = attempt;
    this.most = most;
    this.draw = draw;
    this.width = names.length;
    /** What of it is drawn. */
    this.samples = new History(names);
    /** @type {Float32Array | undefined} */
    this.rows = undefined;
    /** In s. */
    this.time = 0;
    const chosen = input("record");
    chosen.addEventListener("change", () =>
      attempt(async () => {
        const file = chosen.files?.[0];
        await this.open(file).finally(() => {
          chosen.value = "";
        });
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
    if (size > this.most) throw new Error(`${name} has ${size} bytes; at most ${this.most} are read`);
    const rows = await this.machine.read(file);
    await this.machine.lookAway();
    this.rows = rows;
    byId("play-name").textContent = name;
    byId("play-told").textContent = "";
    input("play-at").max = `${this.start(rows.length / this.width - 1)}`;
    document.body.dataset.record = "yes";
    for (const id of ["play", "played"]) byId(id).hidden = false;
    this.draw(this.samples);
    this.seek(0);
  }

  end() {
    this.rows = undefined;
    delete document.body.dataset.record;
    for (const id of ["play", "played"]) byId(id).hidden = true;
    this.draw();
    this.attempt(() => this.machine.lookBack());
  }

  /** When a row was. @param {number} row */
  start(row) {
    return this.rows?.[row * this.width] ?? Infinity;
  }

  /** The first row after a time, as rows tell it. @param {number} time */
  after(time) {
    const told = Math.fround(time);
    let [low, high] = [0, (this.rows?.length ?? 0) / this.width];
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
    this.samples.clear();
    this.plots.follow();
    this.give(time - SHOWN, time);
  }

  /** @param {number} from @param {number} to in s */
  give(from, to) {
    const [first, last] = [from, to].map((time) => this.after(time) * this.width);
    if (this.rows) this.samples.take(this.rows.subarray(first, last));
  }

  show() {
    byId("state").textContent = "a record";
    byId("state").dataset.state = "disarmed";
    for (const id of ["cause", "flying", "trial"]) byId(id).textContent = "";
    input("play-at").value = `${this.time}`;
  }

  /** How the board is, which is not seen. @param {any} status */
  tell({ silent, state, cause }) {
    const is = silent ? "does not answer" : `is now: ${state}${cause ? `, ${cause}` : ""}`;
    const told = this.machine.here
      ? "The simulated board stands still meanwhile."
      : `The board ${is}. STOP, Space and Esc switch its motors off; close the record to fly it.`;
    // Said aloud where it changes.
    if (byId("play-told").textContent !== told) byId("play-told").textContent = told;
    byId("played").dataset.state = silent ? "fault" : state;
  }
}
