// @ts-check
// A recorded flight that the page plays, against its file.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

/** @typedef {import("./driven.mjs").Driven} Driven */

const DEGREES = 180 / Math.PI;

/** The rows of a file by name. @param {string} file */
export function table(file) {
  const [head, ...lines] = readFileSync(file, "utf8").trim().split("\n");
  const names = head.split(",");
  return lines.map((line) => Object.fromEntries(line.split(",").map((value, k) => [names[k], value])));
}

/** @param {number} got @param {number} wanted @param {string} what */
export function same(got, wanted, what) {
  const near = Math.abs(got - wanted) <= 1e-6 * Math.max(1, Math.abs(wanted));
  assert.ok(near, `${what}: ${got} is not ${wanted}`);
}

/** The row that is drawn last. @param {Driven} browser */
export const shown = (browser) => browser.value("({ ...window.twinrotor.samples.row() })");

/** @param {Driven} browser @param {number} time in s */
export const seek = (browser, time) =>
  browser.run(`const slider = document.querySelector("#play-at");
    slider.value = "${time}";
    slider.dispatchEvent(new Event("input"));`);

/** Angles in a file are in rad, on the page in degrees. @param {string} value */
export const inDegrees = (value) => Number(value) * DEGREES;

/** Chooses a file and waits until it is played. @param {Driven} browser @param {string} file */
export async function choose(browser, file) {
  await browser.run("document.querySelector('#play-name').textContent = ''");
  await browser.choose("#record", file);
  const name = file.split("/").at(-1);
  await browser.until(
    `document.querySelector("#play:not([hidden]) #play-name")?.textContent === "${name}"`,
    20_000,
  );
  await browser.until("document.querySelector('#state').textContent === 'a record'", 5_000);
  assert.match(await browser.value("document.querySelector('#played').innerText"), /a record, not a board/);
}

/**
 * What is shown is what `fly` recorded; what a tick decided acts in the next.
 * @param {Driven} browser
 * @param {Record<string, string>[]} rows
 */
export async function compare(browser, rows) {
  for (const tick of [3_000, 5_005]) {
    await seek(browser, tick / 1000);
    const [row, next, got] = [rows[tick], rows[tick + 1], await shown(browser)];
    assert.equal(Number(row.t), tick / 1000);
    same(got.time, Number(row.t), "time");
    for (const [name, column] of [
      ["pitch", "pitch"],
      ["yaw", "yaw"],
      ["pitch_reference", "ref_pitch"],
      ["yaw_rate", "rate_yaw"],
    ])
      same(got[name], inDegrees(row[column]), name);
    same(got.main_volts, Number(next.v0), "main_volts");
    same(got.tail_volts, Number(next.v1), "tail_volts");
    same(got.supply, Number(row.supply), "supply");
  }
}

/** It plays by itself, and stands when it is paused. @param {Driven} browser */
export async function playsAndPauses(browser) {
  const { time } = await shown(browser);
  await browser.until(`window.twinrotor.samples.row().time > ${time + 0.2}`, 20_000);
  await browser.click("#run");
  const paused = await shown(browser);
  await new Promise((go) => setTimeout(go, 400));
  assert.equal((await shown(browser)).time, paused.time);
}
