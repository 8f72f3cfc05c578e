// @ts-check
// The search, in a thread of its own with a module of its own, an exchange at a time.

import { Machine } from "./machine.js";

self.addEventListener("message", async (event) => {
  const { bytes, preset, seed } = event.data;
  try {
    const machine = await Machine.load(bytes);
    machine.ask({ tune: { preset, seed } });
    let seconds = 0;
    for (;;) {
      const from = performance.now();
      const progress = machine.ask("tune-on");
      seconds += (performance.now() - from) / 1000;
      self.postMessage({ ...progress, seconds });
      if (progress.asked.length === 0 || progress.gains_toml) return;
      // A breath, so that whoever looks sees it grow.
      await new Promise((go) => setTimeout(go, 0));
    }
  } catch (error) {
    self.postMessage({ error: String(error) });
  }
});
