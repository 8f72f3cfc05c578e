// @ts-check
// The search in a thread of its own.

import { Module } from "./machine.js";
import { search } from "./search.js";

self.addEventListener("message", async (event) => {
  const { bytes, preset, seed } = event.data;
  try {
    const machine = await Module.load(bytes);
    await search(machine, { preset, seed }, (progress) => {
      self.postMessage(progress);
      return true;
    });
  } catch (error) {
    self.postMessage({ error: String(error) });
  }
});
