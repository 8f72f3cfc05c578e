// @ts-check
// The stop by a key, pressed as a person does and measured in the page: what the driver takes is not in it.

/**
 * How long after `key` came to the browser no motor gets volts any more, as the page is told it.
 * @param {import("./driven.mjs").Driven} browser
 * @param {string} key
 * @returns {Promise<number>} ms
 */
export async function delayOfStop(browser, key) {
  await browser.run(`window.stopped = new Promise((done) => {
    // At the window a key is seen before the page has it.
    const pressed = ({ timeStamp }) => {
      const { main_volts, tail_volts } = window.twinrotor.live.row();
      if (main_volts === 0 && tail_volts === 0) done(performance.now() - timeStamp);
      else setTimeout(pressed, 1, { timeStamp });
    };
    window.addEventListener("keydown", pressed, { capture: true, once: true });
  })`);
  await browser.key(key);
  return browser.value("window.stopped");
}
