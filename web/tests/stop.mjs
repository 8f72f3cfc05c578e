// @ts-check
// The stop by a key, measured in the page.

/**
 * How long after `key` no motor gets volts any more, as the page is told it.
 * @param {import("./chromium.mjs").Chromium} browser
 * @param {string} key
 * @returns {Promise<number>} ms
 */
export function delayOfStop(browser, key) {
  return browser.value(`new Promise((done) => {
    const pressed = performance.now();
    document.dispatchEvent(new KeyboardEvent("keydown", { key: ${JSON.stringify(key)}, bubbles: true }));
    const look = () => {
      const { main_volts, tail_volts } = window.twinrotor.samples.row();
      if (main_volts === 0 && tail_volts === 0) done(performance.now() - pressed);
      else setTimeout(look, 1);
    };
    look();
  })`);
}
