// @ts-check
// The stop by a key, pressed as a person does and measured in the page: what the driver takes is not in it.

/**
 * How long after the page had `key` no motor gets volts any more, as the page is told it.
 * @param {import("./driven.mjs").Driven} browser
 * @param {string} key
 * @returns {Promise<number>} ms
 */
export async function delayOfStop(browser, key) {
  await browser.run(`window.stopped = new Promise((done) => {
    // At the window a key is seen before the page has it.
    // How long a busy machine's browser takes to hand it over is not the page's affair.
    const from = (begun) => {
      const { main_volts, tail_volts } = window.twinrotor.live.row();
      if (main_volts === 0 && tail_volts === 0) done(performance.now() - begun);
      else setTimeout(from, 1, begun);
    };
    window.addEventListener("keydown", () => from(performance.now()), { capture: true, once: true });
  })`);
  await browser.key(key);
  return browser.value("window.stopped");
}
