// @ts-check
// A slider for every setting of the controller, as the core's table has it: drawn up, tried in flight,
// accepted or taken back.

import { button, byId, download, input, make } from "./dom.js";

/** @typedef {import("./machine.js").Machine} Machine */
/**
 * @typedef {object} Row
 * @property {string} name
 * @property {string} part
 * @property {string} unit
 * @property {string} doc
 * @property {string} allowed
 * @property {[number, number]} typical
 * @property {boolean} switch
 * @property {number} draft
 * @property {number | null} accepted
 * @property {number | null} saved
 */

const WORDS = new Map([
  ["law", "gains of the law"],
  ["estimator", "estimator"],
  ["filter", "command filter"],
  ["allocation", "allocation"],
  ["lead", "lead"],
  ["cancellation", "cancellation of the disturbance"],
]);

export class Settings {
  /** @param {Machine} machine @param {import("./attempt.js").Attempt} attempt */
  constructor(machine, attempt) {
    this.machine = machine;
    this.attempt = attempt;
    /** As told last. @type {Row[]} */
    this.rows = [];
    const on = (/** @type {string} */ id, /** @type {import("./machine.js").Request} */ request) =>
      button(id).addEventListener("click", () =>
        attempt(async () => {
          await machine.ask(request);
          await this.build();
        }),
      );
    on("try", "try");
    on("accept", "accept");
    on("revert", "revert");
    on("save", "save");
    on("undo", { recall: { number: 0 } });
    button("export").addEventListener("click", () =>
      attempt(async () => download("gains.toml", [await machine.ask("export")])),
    );
    input("load").addEventListener("change", () => this.load());
  }

  /** Anew from what the machine has: another controller may have other settings. */
  async build() {
    const { name, law, rows, tried, changed } = await this.machine.ask("settings");
    this.rows = rows;
    byId("controller-name").textContent = `${name}: ${law}`;
    /** @type {Map<string, HTMLElement[]>} */
    const parts = new Map();
    for (const row of rows) parts.set(row.part, [...(parts.get(row.part) ?? []), this.row(row)]);
    const open = new Set([...document.querySelectorAll("#settings details[open]")].map((d) => d.id));
    const groups = [...parts].map(([part, all]) => {
      const group = make(
        "details",
        { id: `part-${part}` },
        make("summary", {}, WORDS.get(part) ?? part),
        ...all,
      );
      if (part === "law" || open.has(group.id)) group.setAttribute("open", "");
      return group;
    });
    byId("settings").replaceChildren(...groups);
    this.tell(changed);
    byId("tried").replaceChildren(
      ...tried.map((/** @type {any} */ trial) => {
        const back = make("button", { type: "button" }, `${trial.number}`);
        back.title = "these values into the sliders";
        back.addEventListener("click", () =>
          this.attempt(async () => {
            await this.machine.ask({ recall: { number: trial.number } });
            await this.build();
          }),
        );
        return make("li", {}, back, ` ${trial.words}`);
      }),
    );
  }

  /** @param {number} changed */
  tell(changed) {
    byId("changed").textContent = changed === 0 ? "as accepted" : `${changed} changed`;
  }

  /** @param {Row} row @returns {HTMLElement} */
  row(row) {
    const [low, high] = row.typical;
    const slider = /** @type {HTMLInputElement} */ (
      make("input", {
        type: "range",
        min: `${Math.min(low, row.draft)}`,
        max: `${Math.max(high, row.draft)}`,
        step: row.switch ? "1" : `${(high - low) / 500}`,
        "aria-label": row.name,
      })
    );
    const number = /** @type {HTMLInputElement} */ (
      make("input", {
        type: "number",
        step: "any",
        "aria-label": `${row.name} as a number`,
        inputmode: "decimal",
      })
    );
    slider.value = `${row.draft}`;
    number.value = short(row.draft);
    const unit = row.unit === "-" ? "" : row.unit;
    const labels = row.accepted === null ? "new" : `accepted ${short(row.accepted)}`;
    const told = make("span", { class: "accepted" }, labels);
    const box = make(
      "div",
      { class: "setting", title: `${row.doc} Allowed: ${row.allowed}.`, "data-name": row.name },
      make("span", { class: "name" }, row.name, " ", make("small", {}, unit)),
      slider,
      number,
      told,
    );
    box.classList.toggle("changed", row.accepted !== row.draft);
    slider.addEventListener("input", () => this.set(row, slider.valueAsNumber, box));
    number.addEventListener("change", () => this.set(row, number.valueAsNumber, box));
    return box;
  }

  /** @param {Row} row @param {number} value @param {HTMLElement} box */
  set(row, value, box) {
    this.attempt(async () => {
      await this.machine.ask({ set: { name: row.name, value } });
      row.draft = value;
      const [slider, number] = box.querySelectorAll("input");
      slider.value = `${value}`;
      number.value = short(value);
      box.classList.toggle("changed", row.accepted !== value);
      this.tell(document.querySelectorAll(".setting.changed").length);
    });
  }

  load() {
    const [file] = input("load").files ?? [];
    if (!file) return;
    file.text().then((text) =>
      this.attempt(async () => {
        await this.machine.ask({ load: { gains_toml: text } });
        await this.build();
      }),
    );
  }

  /** What differs from the accepted controller, for a link. @returns {string} */
  changes() {
    const changed = this.rows.filter((row) => row.accepted !== row.draft);
    return changed.map((row) => `${row.name}:${row.draft}`).join(",");
  }

  /** Takes what {@link changes} gave. @param {string} text */
  async take(text) {
    for (const one of text.split(",").filter((part) => part !== "")) {
      const [name, value] = one.split(":");
      await this.attempt(() => this.machine.ask({ set: { name, value: Number(value) } }));
    }
    await this.build();
  }

  /** @param {any} status */
  show(status) {
    const trial = status.trial === "none" ? "" : `trial: ${status.trial} ${status.trial_share} %`;
    byId("trial").textContent = trial || (status.unsaved ? "accepted, not saved" : "");
  }
}

/** As many digits as are read. @param {number} value */
function short(value) {
  return `${Number(value.toPrecision(5))}`;
}
