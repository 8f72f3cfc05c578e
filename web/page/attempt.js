// @ts-check
// Doing something that may not be possible, and telling in words what is wrong with it.

import { byId } from "./dom.js";

/** @typedef {(work: () => Promise<any>) => Promise<void>} Attempt */

/** @type {Attempt} */
export async function attempt(work) {
  try {
    await work();
    byId("told").textContent = "";
  } catch (error) {
    byId("told").textContent = error instanceof Error ? error.message : String(error);
  }
}
