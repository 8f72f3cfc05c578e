// @ts-check
// From a board that lies there to one that flies: check, zero, hold to arm, clear a fault, each with why it
// cannot be done now; and above all, stop.

import { button, byId, make } from "./dom.js";

/** @typedef {import("./machine.js").Machine} Machine */

/** How long arming is held, in ms. */
const HOLD = 1000;
/** Ticks until a word is at the board, the motors are off, and a row of samples says so. */
const OBEYED = 6;

export class Steps {
  /**
   * @param {Machine} machine
   * @param {import("./attempt.js").Attempt} attempt does it, and tells what is wrong
   */
  constructor(machine, attempt) {
    this.machine = machine;
    this.attempt = attempt;
    /** The number of the last entry of the journal that is shown. */
    this.told = 0;
    const on = (/** @type {string} */ id, /** @type {import("./machine.js").Request} */ request) =>
      button(id).addEventListener("click", () => attempt(() => machine.ask(request)));
    on("check", { supervisor: "check" });
    on("zero", "zero");
    on("clear", { supervisor: "clear-fault" });
    button("stop").addEventListener("click", () => this.stop());
    document.addEventListener(
      "keydown",
      (event) => {
        if (event.key !== " " && event.key !== "Escape") return;
        event.preventDefault();
        event.stopPropagation();
        this.stop();
      },
      { capture: true },
    );
    // A browser presses a focused button when Space is let go.
    document.addEventListener(
      "keyup",
      (event) => {
        if (event.key === " ") event.preventDefault();
      },
      { capture: true },
    );
    hold(button("arm"), () => attempt(() => machine.ask({ supervisor: "arm" })));
  }

  /** At once, however slowly this machine draws: the board has the word, and obeys it, before this returns. */
  stop() {
    this.attempt(() => this.machine.ask({ supervisor: "disarm" }));
    this.machine.pass(OBEYED);
  }

  /** @param {any} status */
  show(status) {
    const shown = byId("state");
    shown.textContent = status.silent ? "no answer" : status.state;
    shown.dataset.state = status.silent ? "fault" : status.state;
    byId("cause").textContent = status.silent
      ? (status.trouble ?? "the board is not heard: is the link up?")
      : (status.cause ?? status.trouble ?? "");
    for (const [name, why] of Object.entries(status.steps)) {
      const found = document.getElementById(name);
      if (!(found instanceof HTMLButtonElement)) continue;
      found.disabled = why !== null;
      found.title = why ?? found.dataset.title ?? "";
      found.classList.toggle("next", status.next === name && why === null);
      const told = document.getElementById(`${name}-why`);
      if (told) told.textContent = why ?? "";
    }
    // What only keeps it from being armed stands beside that button.
    const hazards = status.wrong.filter((/** @type {any} */ one) => one.hazard);
    byId("wrong").replaceChildren(
      ...hazards.map((/** @type {any} */ one) => make("li", { class: "hazard" }, one.words)),
    );
    const log = byId("journal");
    for (const entry of status.journal) {
      if (entry.number <= this.told) continue;
      this.told = entry.number;
      const time = `${entry.time.toFixed(1)} s `;
      log.prepend(make("li", { class: entry.trouble ? "hazard" : "" }, make("time", {}, time), entry.words));
    }
    while (log.childElementCount > 60) log.lastElementChild?.remove();
  }
}

/**
 * A button that is to be held for a second, by pointer or by the Enter key.
 * @param {HTMLButtonElement} held
 * @param {() => void} done
 */
function hold(held, done) {
  /** @type {number | undefined} */
  let timer;
  const end = () => {
    clearTimeout(timer);
    timer = undefined;
    held.classList.remove("held");
  };
  const begin = () => {
    if (timer !== undefined || held.disabled) return;
    held.classList.add("held");
    timer = setTimeout(() => {
      end();
      done();
    }, HOLD);
  };
  held.addEventListener("pointerdown", begin);
  for (const name of ["pointerup", "pointerleave", "pointercancel", "blur"]) held.addEventListener(name, end);
  held.addEventListener("keydown", (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    begin();
  });
  held.addEventListener("keyup", end);
}
