// @ts-check
// The paper's search, step by step, on whatever computes.

/**
 * @param {import("./machine.js").Machine} machine
 * @param {{ preset: string, seed: number }} tune
 * @param {(progress: any) => boolean} tell hears how far it is, and whether to go on
 */
export async function search(machine, tune, tell) {
  await machine.ask({ tune });
  let seconds = 0;
  for (;;) {
    const from = performance.now();
    const progress = await machine.ask("tune-on");
    seconds += (performance.now() - from) / 1000;
    if (!tell({ ...progress, seconds })) return;
    if (progress.asked.length === 0 || progress.gains_toml) return;
    // A breath, so that whoever looks sees it grow.
    await new Promise((go) => setTimeout(go, 0));
  }
}
