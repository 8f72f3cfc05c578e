// @ts-check
// The last two flights over each other, with their numbers, which are Rust's: those that `host-sim fly` gives
// for the same record.

import { byId, colour, make } from "./dom.js";

/** @typedef {import("./machine.js").Machine} Machine */

/**
 * What is told of a flight: name, where it is in the report, digits.
 * @type {[string, (report: any) => number | null, number][]}
 */
const NUMBERS = [
  ["settling 2 %, pitch [s]", (report) => report.pitch.settling_time_2, 3],
  ["settling 2 %, yaw [s]", (report) => report.yaw.settling_time_2, 3],
  ["overshoot, pitch [%]", (report) => report.pitch.overshoot_percent, 1],
  ["overshoot, yaw [%]", (report) => report.yaw.overshoot_percent, 1],
  ["ISE, pitch [rad² s]", (report) => report.pitch.ise, 5],
  ["ISE, yaw [rad² s]", (report) => report.yaw.ise, 5],
  ["peak, main [V]", (report) => report.main.peak_volts, 1],
  ["peak, tail [V]", (report) => report.tail.peak_volts, 1],
];

export class Flights {
  /** @param {Machine} machine */
  constructor(machine) {
    this.machine = machine;
    this.shown = 0;
    /** @type {uPlot | undefined} */
    this.plot = undefined;
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(byId("flight-plot"));
  }

  /** @param {any} status */
  show(status) {
    const { flying } = status;
    byId("flying").textContent = !flying
      ? ""
      : flying.rising
        ? `${flying.scenario}: up to level first`
        : `${flying.scenario}: ${flying.time.toFixed(1)} of ${flying.duration} s`;
    if (status.flights === this.shown) return;
    this.shown = status.flights;
    this.build();
  }

  size() {
    return { width: Math.max(byId("flight-plot").clientWidth, 200), height: 190 };
  }

  async build() {
    const flights = await this.machine.ask("flights");
    this.plot?.destroy();
    byId("flights").hidden = flights.length === 0;
    if (flights.length === 0) return;
    this.table(flights);
    this.draw(flights);
  }

  /** @param {any[]} flights */
  table(flights) {
    const title = (/** @type {any} */ flight) => `${flight.number}: ${flight.scenario}, ${flight.controller}`;
    const head = make(
      "tr",
      {},
      make("th", {}),
      ...flights.map((f) => make("th", { scope: "col" }, title(f))),
    );
    const rows = NUMBERS.map(([name, of, digits]) => {
      const told = flights
        .map(({ report }) => of(report))
        .map((value) => make("td", {}, value === null ? "–" : value.toFixed(digits)));
      return make("tr", {}, make("th", { scope: "row" }, name), ...told);
    });
    byId("flight-numbers").replaceChildren(make("thead", {}, head), make("tbody", {}, ...rows));
  }

  /** @param {any[]} flights */
  draw(flights) {
    const holder = byId("flight-plot");
    const last = flights[flights.length - 1];
    const before = flights.length > 1 && flights[0].scenario === last.scenario ? flights[0] : undefined;
    const time = [last, before]
      .map((f) => f?.curves.time ?? [])
      .reduce((a, b) => (a.length > b.length ? a : b));
    /** @type {uPlot.Series[]} */
    const series = [{ label: "time [s]" }];
    /** @type {any[]} */
    const data = [time];
    const line = (
      /** @type {any} */ flight,
      /** @type {string} */ column,
      /** @type {string} */ label,
      /** @type {string} */ tint,
      /** @type {number} */ width,
      /** @type {number[]} */ dash,
    ) => {
      series.push({ label, stroke: colour(tint), width, dash });
      data.push(
        time.map((/** @type {number} */ _, /** @type {number} */ k) => flight.curves[column][k] ?? null),
      );
    };
    line(last, "pitch_reference", "pitch, wanted", "text", 1, [2, 3]);
    line(last, "yaw_reference", "yaw, wanted", "text", 1, [2, 3]);
    for (const [flight, width, dash] of /** @type {[any, number, number[]][]} */ ([
      [before, 1.4, [7, 4]],
      [last, 2.2, []],
    ])) {
      if (!flight) continue;
      line(flight, "pitch", `pitch ${flight.number}`, "pitch", width, dash);
      line(flight, "yaw", `yaw ${flight.number}`, "yaw", width, dash);
    }
    const axis = {
      stroke: colour("text"),
      grid: { stroke: colour("line"), width: 1 },
      font: "12px system-ui",
    };
    this.plot = new uPlot(
      {
        ...this.size(),
        legend: { live: false },
        scales: { x: { time: false } },
        series,
        axes: [
          { ...axis, size: 24 },
          { ...axis, size: 46, label: "angle [°]", labelSize: 16, labelFont: axis.font },
        ],
      },
      /** @type {any} */ (data),
      holder,
    );
  }
}
