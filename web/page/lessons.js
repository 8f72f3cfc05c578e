// @ts-check
// Lessons: a text, and a task whose parts Rust checks by the numbers of the last two flights.

import { byId, make, select } from "./dom.js";

/** @typedef {import("./machine.js").Machine} Machine */
/**
 * @typedef {object} Lesson
 * @property {string} title
 * @property {string[]} paragraphs
 * @property {{ words: string, met: boolean, now: string | null }[]} checks
 */

export class Lessons {
  /** @param {Machine} machine */
  constructor(machine) {
    this.machine = machine;
    /** @type {Lesson[]} */
    this.all = [];
    /** Of which flights and board what is shown tells. */
    this.shown = "";
    select("lesson").addEventListener("change", () => this.draw());
  }

  /** @param {any} status */
  async show(status) {
    const flown = `${status.board} ${status.flights}`;
    if (flown === this.shown) return;
    this.shown = flown;
    this.all = await this.machine.ask("lessons");
    const list = select("lesson");
    const { value } = list;
    list.replaceChildren(
      ...this.all.map(({ title, checks }, k) => {
        const done = checks.every(({ met }) => met) ? " ✓" : "";
        return make("option", { value: `${k}` }, `${k + 1}. ${title}${done}`);
      }),
    );
    list.value = value || "0";
    this.draw();
  }

  draw() {
    const lesson = this.all[Number(select("lesson").value)];
    if (!lesson) return;
    byId("lesson-text").replaceChildren(...lesson.paragraphs.map((text) => make("p", {}, ...inline(text))));
    byId("lesson-checks").replaceChildren(
      ...lesson.checks.map(({ words, met, now }) =>
        make("li", { class: met ? "met" : "" }, met ? "✓ " : "○ ", words, now === null ? "" : ` (now ${now})`),
      ),
    );
  }
}

/** What is `code` and **strong** in a paragraph. @param {string} text @returns {(Node | string)[]} */
function inline(text) {
  return text.split(/(`[^`]*`|\*\*[^*]*\*\*)/).map((part) => {
    if (part.startsWith("`")) return make("code", {}, part.slice(1, -1));
    return part.startsWith("**") ? make("b", {}, part.slice(2, -2)) : part;
  });
}
