// @ts-check
// The page: puts its parts together, lets time pass and keeps the address.

import { read85 } from "./base85.js";
import { Clock } from "./clock.js";
import { button, byId, input, select } from "./dom.js";
import { Flights } from "./flights.js";
import { Helicopter } from "./helicopter.js";
import { History } from "./history.js";
import { read, write } from "./link.js";
import { Machine } from "./machine.js";
import { Plots } from "./plots.js";
import { Rig } from "./rig.js";
import { Settings } from "./settings.js";
import { Steps } from "./steps.js";
import { Tuner } from "./tuner.js";

/** How often words are renewed, in ms. */
const WORDS_EVERY = 100;
/** How often plots are redrawn, in ms. */
const PLOTS_EVERY = 30;

/** Does something, and tells in words what is wrong with it. @param {() => void} work */
function attempt(work) {
  try {
    work();
    byId("told").textContent = "";
  } catch (error) {
    byId("told").textContent = error instanceof Error ? error.message : String(error);
  }
}

/** The bytes of the module, which the page carries in itself, packed. */
async function carried() {
  const unpacked = new Blob([read85(byId("wasm").textContent ?? "")])
    .stream()
    .pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

async function main() {
  const bytes = await carried();
  const machine = await Machine.load(bytes);
  const about = machine.ask("about");
  machine.columns = about.columns.length;
  const samples = new History(about.columns.map((/** @type {any} */ column) => column.name));

  const pass = (/** @type {number} */ ticks) => samples.take(machine.advance(ticks));

  const plots = new Plots(samples);
  const helicopter = new Helicopter((push) => machine.ask({ push }));
  const steps = new Steps(machine, attempt, pass);
  const settings = new Settings(machine, attempt);
  const flights = new Flights(machine);
  const anew = () => {
    samples.clear();
    plots.follow();
    settings.build();
    flights.shown = 0;
    flights.build();
    plots.setLimits(Object.values(machine.ask("status").volts_limit));
  };
  const rig = new Rig(machine, about, attempt, anew, () => settings.build());
  new Tuner(bytes, byId("worker").textContent ?? "", about, (gains_toml) =>
    attempt(() => {
      machine.ask({ load: { gains_toml } });
      settings.build();
    }),
  );

  let told = 0;
  let rowsBefore = -1;
  let drawn = 0;
  const clock = new Clock(pass, () => {
    const now = performance.now();
    if (now - told >= WORDS_EVERY) {
      told = now;
      words();
    }
    const held = plots.range;
    const row = samples.row(held?.[1]);
    if (row) helicopter.draw(row, now);
    const seen = samples.end + (held ? held[0] + held[1] : 0);
    if (seen !== rowsBefore && now - drawn >= PLOTS_EVERY) {
      plots.draw();
      [rowsBefore, drawn] = [seen, now];
    }
  });

  let accepted = "";
  function words() {
    const status = machine.ask("status");
    for (const part of [steps, rig, settings, flights]) part.show(status);
    // What is in force has changed: the sliders say what is accepted.
    const inForce = `${status.trial === "flying"} ${status.unsaved}`;
    if (inForce !== accepted && accepted !== "") settings.build();
    accepted = inForce;
    byId("time").textContent = `${status.time.toFixed(2)} s`;
    const [first, last] = samples.span();
    const scrub = input("scrub");
    [scrub.min, scrub.max] = [`${first}`, `${last}`];
    if (!plots.range) scrub.value = `${last}`;
    button("follow").setAttribute("aria-pressed", `${!plots.range}`);
    remember();
  }

  function remember() {
    write({
      preset: select("preset").value,
      controller: select("controller").value,
      scenario: select("scenario").value,
      speed: select("speed").value,
      main: input("wind-main").value,
      tail: input("wind-tail").value,
      gusts: input("gusts").checked ? 1 : undefined,
      seed: input("seed").value,
      set: settings.changes(),
    });
  }

  const controls = () => {
    button("run").addEventListener("click", () => {
      clock.running = !clock.running;
      button("run").textContent = clock.running ? "pause" : "go on";
    });
    button("tick").addEventListener("click", () => {
      clock.step();
      button("run").textContent = "go on";
    });
    select("speed").addEventListener("change", () => {
      clock.speed = Number(select("speed").value);
    });
    button("follow").addEventListener("click", () => (plots.range ? plots.follow() : plots.hold()));
    button("zoom-in").addEventListener("click", () => plots.scale(0.5));
    button("zoom-out").addEventListener("click", () => plots.scale(2));
    input("scrub").addEventListener("input", () => plots.scrub(input("scrub").valueAsNumber));
    const keys = new Map([
      ["t", "try"],
      ["a", "accept"],
      ["r", "revert"],
      ["f", "fly"],
      ["p", "run"],
      [".", "tick"],
    ]);
    document.addEventListener("keydown", (event) => {
      const typing = event.target instanceof HTMLInputElement && event.target.type === "number";
      const id = keys.get(event.key);
      if (id && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) button(id).click();
    });
    document.addEventListener("visibilitychange", () => {
      clock.before = undefined;
    });
  };

  /** What the address asks for. */
  function restore() {
    const state = read();
    for (const id of ["preset", "controller", "scenario", "speed"]) {
      const wanted = state.get(id);
      if (wanted !== undefined && [...select(id).options].some(({ value }) => value === wanted))
        select(id).value = wanted;
    }
    for (const [id, name] of [
      ["wind-main", "main"],
      ["wind-tail", "tail"],
      ["seed", "seed"],
    ]) {
      const wanted = Number(state.get(name));
      if (state.has(name) && Number.isFinite(wanted)) input(id).value = `${wanted}`;
    }
    input("gusts").checked = state.get("gusts") === "1";
    clock.speed = Number(select("speed").value);
    rig.begin(anew);
    settings.take(state.get("set") ?? "");
  }

  controls();
  select("preset").value = "aero2";
  restore();
  clock.start();
  // For whoever drives the page: a test, a teacher at the browser's console.
  Object.assign(window, { twinrotor: { machine, samples, clock, plots } });
  document.body.dataset.ready = "yes";
}

main().catch((error) => {
  byId("told").textContent = `The page could not begin: ${error}`;
});
