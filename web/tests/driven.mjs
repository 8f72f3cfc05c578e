// @ts-check
// What a person does with a page, for any browser that does it: a subclass passes it on.

/** What stands for keys that are no characters. @type {Map<string, string>} */
const KEYS = new Map([
  ["Enter", "\ue007"],
  ["Escape", "\ue00c"],
]);

export class Driven {
  /**
   * Does something in the page, and gives what a `return` in it gives, once that is there.
   * @param {string} _script statements
   * @returns {Promise<any>}
   */
  run(_script) {
    throw new Error("a browser does it");
  }

  /** Leads to an address. @param {string} _url @returns {Promise<any>} */
  navigate(_url) {
    throw new Error("a browser does it");
  }

  /** Keys and pointers, as the standard lists them. @param {object[]} _actions @returns {Promise<any>} */
  perform(_actions) {
    throw new Error("a browser does it");
  }

  /**
   * Chooses a file as a person does.
   * @param {string} _selector
   * @param {string} _file
   * @returns {Promise<any>}
   */
  choose(_selector, _file) {
    throw new Error("a browser does it");
  }

  /** Opens a page of ours. @param {string} url */
  async open(url) {
    await this.navigate(url);
    await this.until("document.body?.dataset.ready === 'yes'", 20_000);
  }

  /** What an expression comes to in the page. @param {string} expression */
  async value(expression) {
    return this.run(`return (${expression})`).catch((error) => {
      throw new Error(`${expression}: ${error.message}`);
    });
  }

  /** Waits until an expression is true. @param {string} expression @param {number} most in ms */
  async until(expression, most) {
    const end = Date.now() + most;
    while (Date.now() < end) {
      if (await this.value(expression)) return;
      await new Promise((go) => setTimeout(go, 50));
    }
    const shown = await this.value("document.body.innerText.slice(0, 1500)");
    throw new Error(`after ${most} ms still not: ${expression}; the page has: ${shown}`);
  }

  /** Presses a key, and lets it go. @param {string} key @param {number} [held] in ms */
  async key(key, held = 0) {
    const value = KEYS.get(key) ?? key;
    const actions = [
      { type: "keyDown", value },
      { type: "pause", duration: held },
      { type: "keyUp", value },
    ];
    await this.perform([{ type: "key", id: "keys", actions }]);
  }

  /** Holds the mouse's button down upon an element. @param {string} selector @param {number} held in ms */
  async hold(selector, held) {
    const [x, y] = await this.run(`const element = document.querySelector(${JSON.stringify(selector)});
      element.scrollIntoView({ block: "center" });
      const { left, top, width, height } = element.getBoundingClientRect();
      return [left + width / 2, top + height / 2].map(Math.round);`);
    const actions = [
      { type: "pointerMove", x, y },
      { type: "pointerDown", button: 0 },
      { type: "pause", duration: held },
      { type: "pointerUp", button: 0 },
    ];
    const mouse = { type: "pointer", id: "mouse", parameters: { pointerType: "mouse" }, actions };
    await this.perform([mouse]);
  }

  /** Clicks an element with the mouse. @param {string} selector */
  async click(selector) {
    await this.hold(selector, 0);
  }
}
