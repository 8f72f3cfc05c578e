// @ts-check
// The plots of what happens now: angles with references, volts with limits, and one to choose. They follow
// the last seconds, or stand where somebody has zoomed.

import { byId, colour, select } from "./dom.js";

/** @typedef {import("./history.js").History} History */
/** @typedef {{ column: string, label: string, colour: string, dash?: number[] }} Line */

/** @type {Line[]} */
const ANGLES = [
  { column: "pitch", label: "pitch", colour: "pitch" },
  { column: "pitch_reference", label: "its reference", colour: "pitch", dash: [6, 4] },
  { column: "yaw", label: "yaw", colour: "yaw" },
  { column: "yaw_reference", label: "its reference", colour: "yaw", dash: [6, 4] },
];
/** @type {Line[]} */
const VOLTS = [
  { column: "main_volts", label: "main", colour: "main" },
  { column: "tail_volts", label: "tail", colour: "tail", dash: [8, 3] },
];
/** What the third plot can show. @type {Record<string, { unit: string, lines: Line[] }>} */
const THIRD = {
  error: { unit: "error [°]", lines: pair("pitch_error", "yaw_error") },
  rate: { unit: "rate [°/s]", lines: pair("pitch_rate", "yaw_rate") },
  disturbance: { unit: "disturbance [rad/s²]", lines: pair("pitch_disturbance", "yaw_disturbance") },
  rotors: { unit: "at the rotors [V]", lines: motors("main_rotor", "tail_rotor") },
  demand: { unit: "asked for [V]", lines: motors("main_demand", "tail_demand") },
};

/** @param {string} pitch @param {string} yaw @returns {Line[]} */
function pair(pitch, yaw) {
  return [
    { column: pitch, label: "pitch", colour: "pitch" },
    { column: yaw, label: "yaw", colour: "yaw", dash: [8, 3] },
  ];
}

/** @param {string} main @param {string} tail @returns {Line[]} */
function motors(main, tail) {
  return [
    { column: main, label: "main", colour: "main" },
    { column: tail, label: "tail", colour: "tail", dash: [8, 3] },
  ];
}

export class Plots {
  /** @param {History} history */
  constructor(history) {
    this.history = history;
    /** Seconds that are shown. */
    this.span = 10;
    /** Where it stands, or nothing: it follows. @type {[number, number] | undefined} */
    this.range = undefined;
    /** @type {number[]} */
    this.limits = [];
    /** @type {{ plot: uPlot, lines: Line[], holder: HTMLElement }[]} */
    this.all = [];
    select("third").addEventListener("change", () => this.build());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    new ResizeObserver(() => this.resize()).observe(byId("plots"));
    this.build();
  }

  /** From now on these. @param {History} history @param {number[]} limits of the motors, in V */
  show(history, limits) {
    [this.history, this.limits, this.range] = [history, limits, undefined];
    this.build();
  }

  build() {
    for (const { plot } of this.all) plot.destroy();
    const third = THIRD[select("third").value] ?? THIRD.error;
    this.all = [
      this.one("plot-angles", "angle [°]", ANGLES),
      this.one("plot-volts", "volts [V]", VOLTS, [...new Set(this.limits)]),
      this.one("plot-third", third.unit, third.lines),
    ];
  }

  /** @param {string} id @param {string} label @param {Line[]} lines @param {number[]} limits */
  one(id, label, lines, limits = []) {
    const holder = byId(id);
    const axis = {
      stroke: colour("text"),
      grid: { stroke: colour("line"), width: 1 },
      ticks: { show: false },
    };
    const font = "12px system-ui";
    const most = Math.max(...limits, 0);
    /** @type {uPlot.Options} */
    const options = {
      ...this.size(holder),
      cursor: { sync: { key: "time" }, drag: { x: true, y: false } },
      legend: { live: false },
      scales: { x: { time: false }, y: most ? { range: [-1.15 * most, 1.15 * most] } : { range: roomy } },
      axes: [
        { ...axis, font, size: 24 },
        { ...axis, font, size: 46, label, labelSize: 16, labelFont: font },
      ],
      series: [
        { label: "time [s]" },
        ...lines.map((line) => ({
          label: line.label,
          stroke: colour(line.colour),
          width: 1.6,
          dash: line.dash,
        })),
      ],
      hooks: {
        setSelect: [(/** @type {uPlot} */ plot) => this.zoom(plot)],
        draw: limits.length ? [(/** @type {uPlot} */ plot) => drawLimits(plot, limits)] : [],
      },
    };
    const plot = new uPlot(options, this.data(lines), holder);
    plot.over.addEventListener("dblclick", () => this.follow());
    return { plot, lines, holder };
  }

  /** @param {HTMLElement} holder */
  size(holder) {
    return { width: Math.max(holder.clientWidth, 200), height: Math.max(holder.clientHeight - 26, 90) };
  }

  resize() {
    for (const { plot, holder } of this.all) plot.setSize(this.size(holder));
  }

  /** What is shown now, in s. @returns {[number, number]} */
  shown() {
    const last = this.history.span()[1];
    return this.range ?? [Math.max(last - this.span, 0), Math.max(last, this.span)];
  }

  /** @param {Line[]} lines @returns {uPlot.AlignedData} */
  data(lines) {
    const [from, to] = this.shown();
    const names = ["time", ...lines.map((line) => line.column)];
    return /** @type {any} */ (this.history.window(names, from, to));
  }

  draw() {
    const [min, max] = this.shown();
    for (const { plot, lines } of this.all) {
      plot.batch(() => {
        plot.setData(this.data(lines), false);
        plot.setScale("x", { min, max });
      });
    }
  }

  /** @param {uPlot} plot in which a range was drawn */
  zoom(plot) {
    const { left, width } = plot.select;
    if (width < 8) return;
    this.range = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  /** Stands where it is. */
  hold() {
    this.range = this.shown();
  }

  follow() {
    this.range = undefined;
  }

  /** @param {number} factor on the seconds that are shown */
  scale(factor) {
    if (!this.range) {
      this.span = Math.min(Math.max(this.span * factor, 0.5), 60);
      return;
    }
    const [from, to] = this.range;
    const [middle, half] = [(from + to) / 2, (factor * (to - from)) / 2];
    this.range = [Math.max(middle - half, 0), middle + half];
  }

  /** Where it stands is moved to end at a time, in s. @param {number} time */
  scrub(time) {
    const [from, to] = this.shown();
    this.range = [time - (to - from), time];
  }
}

/**
 * A y range with some room, never a hair's breadth.
 * @param {uPlot} _ @param {number} low @param {number} high
 */
function roomy(_, low, high) {
  const [least, most] = [low ?? -1, high ?? 1];
  const room = Math.max(0.08 * (most - least), 0.5);
  return /** @type {[number, number]} */ ([least - room, most + room]);
}

/** The motors' limits, dotted. @param {uPlot} plot @param {number[]} limits */
function drawLimits(plot, limits) {
  const { ctx } = plot;
  ctx.save();
  ctx.strokeStyle = colour("text");
  ctx.setLineDash([2, 4]);
  for (const limit of limits.flatMap((volts) => [volts, -volts])) {
    const y = plot.valToPos(limit, "y", true);
    ctx.beginPath();
    ctx.moveTo(plot.bbox.left, y);
    ctx.lineTo(plot.bbox.left + plot.bbox.width, y);
    ctx.stroke();
  }
  ctx.restore();
}
