// @ts-check
// A headless Chromium by its driver, and what only Chromium has: `goog/cdp/execute` passes a word of its
// DevTools' protocol on. Debian has both programs: apt-get install chromium chromium-driver

import { existsSync } from "node:fs";
import { join } from "node:path";
import { WebDriver } from "./webdriver.mjs";

const BROWSERS = [
  process.env.CHROMIUM ?? "",
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
];
const DRIVERS = [process.env.CHROMEDRIVER ?? "", "/usr/bin/chromedriver"];

const found = (/** @type {string[]} */ places) => places.find((place) => place !== "" && existsSync(place));

export class Chromium extends WebDriver {
  /** One that has begun; where there is none that is said, and that is all. */
  static async start() {
    const [program, driver] = [found(BROWSERS), found(DRIVERS)];
    if (!program || !driver) {
      console.log("not run: there is no Chromium with its driver (apt-get install chromium chromium-driver)");
      process.exit(0);
    }
    const browser = new Chromium(program, driver);
    try {
      await browser.begin();
    } catch (error) {
      await browser.close();
      throw error;
    }
    return browser;
  }

  /** @param {string} program @param {string} driver */
  constructor(program, driver) {
    super(driver, (downloads) => ({
      browserName: "chrome",
      "goog:loggingPrefs": { browser: "ALL", performance: "ALL" },
      "goog:chromeOptions": {
        binary: program,
        prefs: { "download.default_directory": downloads },
        perfLoggingPrefs: { enableNetwork: true, enablePage: false },
        args: [
          "--headless=new",
          // Where the driver is killed the pipe breaks, and with it the browser ends.
          "--remote-debugging-pipe",
          "--no-sandbox",
          "--no-first-run",
          "--hide-scrollbars",
          "--enable-unsafe-swiftshader",
          "--use-angle=swiftshader",
          // Debian's launcher asks for a card's rasterization; emulated, it takes half a second a frame.
          "--disable-gpu-compositing",
          "--disable-gpu-rasterization",
        ],
      },
    }));
  }

  /** The browser's process, which the standard does not tell. @returns {number} */
  get id() {
    return this.has["goog:processID"];
  }

  /** @param {string} cmd @param {object} [params] @returns {Promise<any>} */
  cdp(cmd, params = {}) {
    return this.ask("/goog/cdp/execute", { cmd, params });
  }

  /**
   * A desk's window, or a phone. The standard has no phones, and a window of Chromium is no narrower than
   * 500; nor has it what a person prefers, light or dark.
   * @param {number} width @param {number} height @param {boolean} dark
   */
  async size(width, height, dark) {
    if (width < 600) {
      const phone = { width, height, deviceScaleFactor: 1, mobile: true };
      await this.cdp("Emulation.setDeviceMetricsOverride", phone);
    } else {
      await this.cdp("Emulation.clearDeviceMetricsOverride");
      await this.window(width, height);
    }
    const preferred = { name: "prefers-color-scheme", value: dark ? "dark" : "light" };
    await this.cdp("Emulation.setEmulatedMedia", { features: [preferred] });
    await new Promise((go) => setTimeout(go, 600));
  }

  /** What the browser has noted of a kind since it was asked last; the standard has no logs. */
  async noted(/** @type {string} */ type) {
    /** @type {{ level: string, message: string }[]} */
    const notes = [];
    // It gives so many at a time.
    for (;;) {
      const part = await this.ask("/se/log", { type });
      if (part.length === 0) return notes;
      notes.push(...part);
    }
  }

  /** What went wrong in the page. @returns {Promise<string[]>} */
  async troubles() {
    const notes = await this.noted("browser");
    return notes.filter(({ level }) => level === "SEVERE").map(({ message }) => message);
  }

  /** What was asked of the network. @returns {Promise<string[]>} */
  async requests() {
    const notes = await this.noted("performance");
    const told = notes.map(({ message }) => JSON.parse(message).message);
    return told.flatMap(({ method, params }) => {
      if (method === "Network.requestWillBeSent") return [params.request.url];
      return method === "Network.webSocketCreated" ? [params.url] : [];
    });
  }

  /** Where a file is, once it has been downloaded. @param {string} name @returns {Promise<string>} */
  async downloaded(name) {
    const place = join(this.folder, name);
    for (const end = Date.now() + 10_000; !existsSync(place); ) {
      if (Date.now() > end) throw new Error(`${name} was not downloaded`);
      await new Promise((go) => setTimeout(go, 50));
    }
    return place;
  }
}
