// @ts-check
// A browser that is driven as the standard has it (https://www.w3.org/TR/webdriver2/): a driver program of
// its vendor is asked over HTTP. No package beside Node. What a vendor has beyond that is in another file.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { Driven } from "./driven.mjs";

/** How long a driver may take until it listens, in ms. */
const BEGINS = 20_000;
/** How long a script may take in the page, in ms: a long flight of a board at a port. */
const SCRIPT = 240_000;
/** By what an element goes in an answer. */
const ELEMENT = "element-6066-11e4-a52e-4f735466cecf";

export class WebDriver extends Driven {
  /**
   * A driver program and a session with it.
   * @param {string} program
   * @param {(folder: string) => object} capabilities that the session must have
   */
  constructor(program, capabilities) {
    super();
    /** What driver and browser write is here, until they have ended. */
    this.folder = mkdtempSync(join(tmpdir(), "twinrotor-page-"));
    const env = { ...process.env, TMPDIR: this.folder };
    this.process = spawn(program, ["--port=0"], { stdio: ["ignore", "pipe", "ignore"], env });
    // However this program ends, the driver ends with it, and with the driver its browser.
    process.once("exit", () => {
      this.process.kill("SIGKILL");
      this.clear();
    });
    for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.once(signal, () => process.exit(1));
    this.capabilities = capabilities(this.folder);
    /** Of the driver, then of the session. */
    this.at = "";
    /** What the session has. @type {Record<string, any>} */
    this.has = {};
  }

  /** Until there is a browser. */
  async begin() {
    let told = "";
    const port = await new Promise((go, fail) => {
      const late = setTimeout(() => fail(new Error(`the driver does not listen: ${told}`)), BEGINS);
      this.process.once("error", fail);
      this.process.once("exit", () => fail(new Error(`the driver has ended: ${told}`)));
      this.process.stdout.on("data", (chunk) => {
        told += chunk;
        const found = /successfully on port (\d+)/.exec(told);
        if (!found) return;
        clearTimeout(late);
        go(found[1]);
      });
    });
    this.at = `http://127.0.0.1:${port}/session`;
    const alwaysMatch = { timeouts: { script: SCRIPT }, ...this.capabilities };
    const { sessionId, capabilities } = await this.ask("", { capabilities: { alwaysMatch } });
    this.at += `/${sessionId}`;
    this.has = capabilities;
  }

  /**
   * Asks the driver: with something to say, to do it.
   * @param {string} path
   * @param {object} [what]
   * @param {string} [method]
   * @returns {Promise<any>}
   */
  async ask(path, what, method = what ? "POST" : "GET") {
    const answer = await fetch(this.at + path, { method, body: what && JSON.stringify(what) });
    const { value } = /** @type {any} */ (await answer.json());
    if (!answer.ok) throw new Error(`${path}: ${value.error}: ${value.message}`);
    return value;
  }

  /** @param {string} url */
  navigate(url) {
    return this.ask("/url", { url });
  }

  /** @param {string} script */
  run(script) {
    return this.ask("/execute/sync", { script, args: [] });
  }

  /** @param {object[]} actions */
  perform(actions) {
    return this.ask("/actions", { actions });
  }

  /** An element, in the middle of what is in sight: the page's head covers what is above. */
  async element(/** @type {string} */ selector) {
    const element = await this.run(`const element = document.querySelector(${JSON.stringify(selector)});
      element?.scrollIntoView({ block: "center" });
      return element;`);
    if (!element) throw new Error(`the page has no ${selector}`);
    return /** @type {string} */ (element[ELEMENT]);
  }

  /** Clicks an element, which nothing may cover. @param {string} selector */
  async click(selector) {
    await this.ask(`/element/${await this.element(selector)}/click`, {});
  }

  /** Chooses a file as a person does. @param {string} selector @param {string} file */
  async choose(selector, file) {
    await this.ask(`/element/${await this.element(selector)}/value`, { text: resolve(file) });
  }

  /** A window that shows so much of a page. @param {number} width @param {number} height */
  async window(width, height) {
    const [more, higher] = await this.value("[outerWidth - innerWidth, outerHeight - innerHeight]");
    await this.ask("/window/rect", { width: width + more, height: height + higher });
  }

  /** @returns {Promise<Buffer>} of PNG */
  async screenshot() {
    return Buffer.from(await this.ask("/screenshot"), "base64");
  }

  async close() {
    const ended = new Promise((go) => this.process.once("exit", go));
    // The browser ends by itself, and its profile goes; or it ends with its driver.
    if (this.has.browserName) await this.ask("", undefined, "DELETE").catch(() => {});
    if (this.process.kill()) await ended;
    this.clear();
  }

  clear() {
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}
