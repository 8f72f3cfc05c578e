// @ts-check
// A record of every tick: begun and ended here, kept by whoever has the board, taken out as CSV.

import { button, byId, download } from "./dom.js";

export class Recorder {
  /**
   * @param {import("./machine.js").Machine} machine
   * @param {import("./attempt.js").Attempt} attempt
   */
  constructor(machine, attempt) {
    this.machine = machine;
    this.on = false;
    button("record-begin").addEventListener("click", () =>
      attempt(async () => {
        const ends = this.on;
        await machine.ask({ record: !ends });
        if (ends) await this.keep();
      }),
    );
    button("record-keep").addEventListener("click", () => attempt(() => this.keep()));
  }

  /** As a file, part by part. */
  async keep() {
    /** @type {string[]} */
    const parts = [];
    for (let next = 0; next !== null; ) {
      const part = await this.machine.ask({ recorded: { from: next } });
      parts.push(part.csv);
      next = part.next;
    }
    download("flight.csv", parts);
  }

  /** @param {any} status */
  show({ record }) {
    const { on, frames, gaps, lost_ticks: lost, by_program: program } = record;
    this.on = on;
    button("record-begin").textContent = on ? "end the record" : "record";
    button("record-begin").setAttribute("aria-pressed", `${on}`);
    button("record-begin").disabled = program;
    byId("record-keep").hidden = on || frames === 0 || program;
    const missing = gaps === 0 ? "" : `, ${gaps} gaps of ${lost} ticks in all`;
    byId("record-told").textContent = frames === 0 ? "" : `${frames} ticks recorded${missing}`;
  }
}
