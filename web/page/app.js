// @ts-check
// The page: puts its parts together, lets time pass and keeps the address.

import { attempt } from "./attempt.js";
import { carried, carriedText } from "./carried.js";
import { Clock } from "./clock.js";
import { Control } from "./control.js";
import { button, byId, input, select } from "./dom.js";
import { Flights } from "./flights.js";
import { Helicopter } from "./helicopter.js";
import { History } from "./history.js";
import { Lessons } from "./lessons.js";
import { read, write } from "./link.js";
import { Module } from "./machine.js";
import { Pace } from "./pace.js";
import { Player } from "./player.js";
import { Plots } from "./plots.js";
import { Recorder } from "./recorder.js";
import { Rig } from "./rig.js";
import { Serial } from "./serial.js";
import { Settings } from "./settings.js";
import { Socket } from "./socket.js";
import { Steps } from "./steps.js";
import { Tuner } from "./tuner.js";

/** How often words are renewed, in ms; a program that has the board hears by that that somebody is here. */
const WORDS_EVERY = 100;

async function main() {
  const bytes = await carried("wasm");
  const machine = bytes ? await Module.load(bytes) : await Socket.open();
  const about = await machine.ask("about");
  const samples = new History(about.columns.map((/** @type {any} */ column) => column.name));
  document.body.dataset.way = machine.here ? "here" : "there";

  const plots = new Plots(samples);
  const helicopter = new Helicopter((push) => void machine.ask({ push }).catch(() => {}));
  const steps = new Steps(machine, attempt);
  const settings = new Settings(machine, attempt);
  const flights = new Flights(machine);
  const rig = new Rig(machine, about, attempt, () => settings.build());
  const lessons = new Lessons(machine);
  const recorder = new Recorder(machine, attempt);
  const load = (/** @type {string} */ gains_toml) =>
    attempt(async () => {
      await machine.ask({ load: { gains_toml } });
      await settings.build();
    });
  new Tuner(machine, bytes, await carriedText("worker"), about, load);
  const stop = () => steps.stop();
  const control = machine instanceof Socket ? new Control(machine, attempt, stop) : undefined;
  const serial =
    machine instanceof Module
      ? new Serial(machine, about.baud, attempt, stop, () => rig.begin())
      : undefined;

  let board = -1;
  /** Of the motors, in V. @type {number[]} */
  let limits = [];
  /** The record, or the board. @param {History} [record] */
  const draw = (record) => {
    plots.show(record ?? samples, record ? [] : limits);
    control?.show();
  };
  const player = new Player(machine, samples.names, plots, attempt, about.record_bytes, draw);
  machine.rows = (rows) => samples.take(rows);

  const pace = new Pace();
  let rowsBefore = -1;
  let drawn = 0;
  const clock = new Clock(
    (ticks) => (player.rows ? player.pass(ticks) : machine.pass(ticks)),
    () => {
      const now = performance.now();
      const { range: held, history } = plots;
      const row = pace.frame(now) ? history.row(held?.[1]) : undefined;
      if (row) helicopter.draw(row, now, pace.level.part);
      const seen = history.end + (held ? held[0] + held[1] : 0);
      if (seen !== rowsBefore && now - drawn >= pace.level.plots) {
        plots.draw();
        [rowsBefore, drawn] = [seen, now];
      }
    },
  );

  let inForce = "";
  let asking = false;
  /** Not with what is drawn: a page that draws slowly is still there. */
  async function words() {
    if (player.rows) {
      player.show();
      span(player.time);
    }
    if (asking) return;
    asking = true;
    try {
      const status = await machine.ask({ status: { since: steps.told } });
      if (player.rows) player.tell(status);
      else await show(status);
    } catch {
      // That nobody answers is told by whoever holds the socket.
      player.tell({ silent: true });
    } finally {
      asking = false;
    }
  }

  /** @param {any} status */
  async function show(status) {
    if (status.board !== board) {
      board = status.board;
      samples.clear();
      flights.shown = -1;
      limits = Object.values(status.volts_limit);
      draw();
      await settings.build();
    }
    for (const part of [steps, rig, settings, flights, lessons, recorder]) part.show(status);
    control?.show();
    // What is in force has changed: the sliders say what is accepted.
    const now = `${status.trial === "flying"} ${status.unsaved}`;
    if (now !== inForce && inForce !== "") await settings.build();
    inForce = now;
    span(status.time);
    if (machine.here) remember();
  }

  /** What can be looked back at. @param {number} time now, in s */
  function span(time) {
    byId("time").textContent = `${time.toFixed(2)} s`;
    const [first, last] = plots.history.span();
    const scrub = input("scrub");
    [scrub.min, scrub.max] = [`${first}`, `${last}`];
    if (!plots.range) scrub.value = `${last}`;
    button("follow").setAttribute("aria-pressed", `${!plots.range}`);
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
      // What is not shown, as beside a record, cannot be meant.
      const shown = id && button(id).offsetParent !== null;
      if (shown && !typing && !event.ctrlKey && !event.metaKey && !event.altKey) button(id).click();
    });
    document.addEventListener("visibilitychange", () => {
      clock.before = undefined;
      pace.forget();
    });
  };

  /** What the address asks for. */
  async function restore() {
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
    await rig.begin();
    await settings.take(state.get("set") ?? "");
  }

  controls();
  select("preset").value = "aero2";
  if (machine.here) await restore();
  await words();
  setInterval(words, WORDS_EVERY);
  clock.start();
  // For whoever drives the page: a test, a teacher at the browser's console.
  const parts = { machine, live: samples, clock, pace, plots, serial, player, bytes };
  Object.assign(window, { twinrotor: Object.defineProperty(parts, "samples", { get: () => plots.history }) });
  document.body.dataset.ready = "yes";
}

main().catch((error) => {
  byId("told").textContent = `The page could not begin: ${error}`;
});
