// @ts-check
// What is flown and what disturbs it: preset, controller, scenario, goal, wind, and faults to click.

import { button, byId, choices, input, make, select } from "./dom.js";

/** @typedef {import("./machine.js").Machine} Machine */

export class Rig {
  /**
   * @param {Machine} machine @param {any} about @param {import("./attempt.js").Attempt} attempt
   * @param {() => Promise<void>} drawn the draft is another controller
   */
  constructor(machine, about, attempt, drawn) {
    this.machine = machine;
    this.attempt = attempt;
    choices("preset", about.presets);
    choices("controller", about.controllers);
    choices("scenario", about.scenarios);
    select("preset").addEventListener("change", () => this.begin());
    select("controller").addEventListener("change", () =>
      attempt(async () => {
        await machine.ask({ draw: { controller: select("controller").value } });
        await drawn();
      }),
    );
    button("begin").addEventListener("click", () => this.begin());
    /** Scenario files that were opened, by name. @type {Map<string, string>} */
    this.opened = new Map();
    button("fly").addEventListener("click", () => {
      const scenario = select("scenario").value;
      attempt(() => machine.ask({ fly: { scenario, toml: this.opened.get(scenario) } }));
    });
    input("scenario-file").addEventListener("change", () =>
      attempt(async () => {
        const file = input("scenario-file").files?.[0];
        if (file) this.open(file.name, await file.text());
        input("scenario-file").value = "";
      }),
    );
    for (const id of ["aim-pitch", "aim-yaw"]) input(id).addEventListener("input", () => this.aim());
    for (const id of ["wind-main", "wind-tail", "gusts"])
      input(id).addEventListener("input", () => this.disturb());
    input("steady").addEventListener("change", () => this.steady());
    /** @type {Map<string, HTMLInputElement>} */
    this.faults = new Map();
  }

  /** A board with the chosen rig and controller. */
  begin() {
    return this.attempt(async () => {
      const [preset, controller] = ["preset", "controller"].map((id) => select(id).value);
      await this.machine.ask({ begin: { preset, controller } });
      for (const id of ["aim-pitch", "aim-yaw"]) input(id).value = "0";
      await Promise.all([this.disturb(), this.steady()]);
    });
  }

  /** A scenario file is one to choose. @param {string} name @param {string} text */
  open(name, text) {
    if (!this.opened.has(name)) select("scenario").append(make("option", { value: name }, name));
    this.opened.set(name, text);
    select("scenario").value = name;
  }

  aim() {
    const [pitch_deg, yaw_deg] = ["aim-pitch", "aim-yaw"].map((id) => input(id).valueAsNumber);
    this.attempt(() => this.machine.ask({ aim: { pitch_deg, yaw_deg } }));
    byId("aim-told").textContent = `${pitch_deg}° pitch, ${yaw_deg}° yaw`;
  }

  disturb() {
    const [main, tail] = ["wind-main", "wind-tail"].map((id) => input(id).valueAsNumber);
    byId("wind-told").textContent = `${main} V at the main rotor, ${tail} V at the tail`;
    return this.attempt(() => this.machine.ask({ disturb: { main, tail, gusts: input("gusts").checked } }));
  }

  steady() {
    return this.attempt(() => this.machine.ask({ steady: input("steady").checked }));
  }

  /** @param {any} status */
  show(status) {
    document.body.dataset.rig = status.simulated ? "simulated" : "real";
    if (status.simulated && select("preset").value !== status.preset) select("preset").value = status.preset;
    if (this.faults.size === 0) this.list(status.faults);
    for (const { name, present } of status.faults) {
      const box = this.faults.get(name);
      if (box) box.checked = present;
    }
    for (const id of ["aim-pitch", "aim-yaw"]) input(id).disabled = status.state !== "armed";
  }

  /** @param {any[]} faults */
  list(faults) {
    const boxes = faults.map(({ name, words }) => {
      const box = /** @type {HTMLInputElement} */ (make("input", { type: "checkbox", "data-fault": name }));
      box.addEventListener("change", () =>
        this.attempt(() => this.machine.ask({ fault: { name, present: box.checked } })),
      );
      this.faults.set(name, box);
      return make("label", {}, box, ` ${words}`);
    });
    byId("faults").replaceChildren(...boxes);
  }
}
