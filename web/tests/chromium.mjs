// @ts-check
// A headless Chromium over its DevTools pipe: no driver program and no package beside Node.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const PLACES = [
  process.env.CHROMIUM ?? "",
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
];

/** Where there is one, if there is. @returns {string | undefined} */
export function installed() {
  return PLACES.find((place) => place !== "" && existsSync(place));
}

export class Chromium {
  /** @param {string} program */
  constructor(program) {
    this.folder = mkdtempSync(join(tmpdir(), "twinrotor-page-"));
    this.process = spawn(
      program,
      [
        "--headless=new",
        "--remote-debugging-pipe",
        "--no-sandbox",
        "--no-first-run",
        "--hide-scrollbars",
        "--enable-unsafe-swiftshader",
        "--use-angle=swiftshader",
        // Debian's launcher asks for a card's rasterization; emulated, it takes half a second a frame.
        "--disable-gpu-compositing",
        "--disable-gpu-rasterization",
        `--user-data-dir=${this.folder}`,
        "about:blank",
      ],
      { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] },
    );
    const [, , , to, from] = this.process.stdio;
    this.to = /** @type {import("node:stream").Writable} */ (to);
    this.waiting = new Map();
    this.number = 0;
    /** What went wrong in the page. @type {string[]} */
    this.troubles = [];
    /** What was asked of the network. @type {string[]} */
    this.requests = [];
    let text = "";
    /** @type {import("node:stream").Readable} */ (from).on("data", (chunk) => {
      text += chunk;
      const messages = text.split("\0");
      text = messages.pop() ?? "";
      for (const message of messages) this.take(JSON.parse(message));
    });
  }

  /** @param {any} message */
  take(message) {
    const { id, method, params } = message;
    if (method === "Runtime.exceptionThrown") this.troubles.push(JSON.stringify(params.exceptionDetails));
    if (method === "Log.entryAdded" && params.entry.level === "error") this.troubles.push(params.entry.text);
    if (method === "Network.requestWillBeSent") this.requests.push(params.request.url);
    const waiting = this.waiting.get(id);
    if (!waiting) return;
    this.waiting.delete(id);
    if (message.error) waiting.reject(new Error(`${waiting.method}: ${message.error.message}`));
    else waiting.resolve(message.result);
  }

  /** @param {string} method @param {object} [params] @returns {Promise<any>} */
  send(method, params = {}) {
    this.number += 1;
    const id = this.number;
    this.to.write(`${JSON.stringify({ id, method, params, sessionId: this.session })}\0`);
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject, method }));
  }

  /** Opens a page. @param {string} url */
  async open(url) {
    const { targetInfos } = await this.send("Target.getTargets");
    const { targetId } = targetInfos.find((/** @type {any} */ target) => target.type === "page");
    ({ sessionId: this.session } = await this.send("Target.attachToTarget", { targetId, flatten: true }));
    for (const domain of ["Page", "Runtime", "Log", "Network"]) await this.send(`${domain}.enable`);
    await this.send("Page.navigate", { url });
    await this.until("document.body?.dataset.ready === 'yes'", 20_000);
  }

  /** What an expression comes to in the page. @param {string} expression */
  async value(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", {
      expression,
      awaitPromise: true,
      returnByValue: true,
    });
    if (exceptionDetails) throw new Error(`${expression}: ${exceptionDetails.exception?.description}`);
    return result.value;
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
    const text = key === "Enter" ? "\r" : key.length === 1 ? key : undefined;
    await this.send("Input.dispatchKeyEvent", { type: "keyDown", key, text });
    await new Promise((go) => setTimeout(go, held));
    await this.send("Input.dispatchKeyEvent", { type: "keyUp", key });
  }

  /** The middle of an element, once it is in view. @param {string} selector */
  async place(selector) {
    return this.value(`(() => {
      const element = document.querySelector(${JSON.stringify(selector)});
      element.scrollIntoView({ block: "center" });
      const { x, y, width, height } = element.getBoundingClientRect();
      return { x: x + width / 2, y: y + height / 2 };
    })()`);
  }

  /** Clicks an element with the mouse. @param {string} selector @param {number} [held] in ms */
  async click(selector, held = 0) {
    const place = await this.place(selector);
    const mouse = (/** @type {string} */ type) =>
      this.send("Input.dispatchMouseEvent", { type, ...place, button: "left", clickCount: 1 });
    await mouse("mouseMoved");
    await mouse("mousePressed");
    await new Promise((go) => setTimeout(go, held));
    await mouse("mouseReleased");
  }

  /** @param {number} width @param {number} height @param {boolean} dark */
  async size(width, height, dark) {
    await this.send("Emulation.setDeviceMetricsOverride", {
      width,
      height,
      deviceScaleFactor: 1,
      mobile: width < 600,
    });
    await this.send("Emulation.setEmulatedMedia", {
      features: [{ name: "prefers-color-scheme", value: dark ? "dark" : "light" }],
    });
    await new Promise((go) => setTimeout(go, 600));
  }

  /** @returns {Promise<Buffer>} */
  async screenshot() {
    const { data } = await this.send("Page.captureScreenshot", { format: "png" });
    return Buffer.from(data, "base64");
  }

  async close() {
    const ended = new Promise((go) => this.process.once("exit", go));
    this.process.kill();
    await ended;
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}
