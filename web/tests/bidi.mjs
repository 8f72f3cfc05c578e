// @ts-check
// A headless Firefox, which speaks WebDriver BiDi (https://www.w3.org/TR/webdriver-bidi/) by itself, over a
// socket: Debian has no driver program for it. Node 20 has sockets where it is told so
// (--experimental-websocket).

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { Driven } from "./driven.mjs";

/** How long it may take until it listens, in ms. */
const BEGINS = 30_000;

export class Firefox extends Driven {
  /** @param {string} program */
  constructor(program) {
    super();
    this.folder = mkdtempSync(join(tmpdir(), "twinrotor-page-"));
    const flags = ["--headless", "--no-remote", "--remote-debugging-port=0", "--profile", this.folder];
    this.process = spawn(program, flags, { stdio: ["ignore", "ignore", "pipe"] });
    process.once("exit", () => this.process.kill("SIGKILL"));
    for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.once(signal, () => process.exit(1));
    /** @type {Map<number, (answer: any) => void>} */
    this.waiting = new Map();
    this.number = 0;
    this.context = "";
    /** What went wrong in the page. @type {string[]} */
    this.troubles = [];
  }

  async begin() {
    let told = "";
    const at = await new Promise((go, fail) => {
      setTimeout(() => fail(new Error(`Firefox does not listen: ${told}`)), BEGINS).unref();
      this.process.once("error", fail);
      this.process.stderr.on("data", (chunk) => {
        told += chunk;
        const found = /WebDriver BiDi listening on (ws:\S+)/.exec(told);
        if (found) go(found[1]);
      });
    });
    this.socket = new WebSocket(`${at}/session`);
    this.socket.addEventListener("message", ({ data }) => this.take(JSON.parse(data)));
    await new Promise((go, fail) => {
      this.socket?.addEventListener("open", go);
      this.socket?.addEventListener("error", fail);
    });
    await this.ask("session.new", { capabilities: {} });
    const { contexts } = await this.ask("browsingContext.getTree", {});
    this.context = contexts[0].context;
    await this.ask("session.subscribe", { events: ["log.entryAdded"] });
  }

  /** @param {any} told */
  take(told) {
    if (told.method === "log.entryAdded" && told.params.level === "error")
      this.troubles.push(told.params.text);
    this.waiting.get(told.id)?.(told);
    this.waiting.delete(told.id);
  }

  /** @param {string} method @param {object} params @returns {Promise<any>} */
  async ask(method, params) {
    this.number += 1;
    const id = this.number;
    this.socket?.send(JSON.stringify({ id, method, params }));
    const { error, message, result } = await new Promise((go) => this.waiting.set(id, go));
    if (error) throw new Error(`${method}: ${error}: ${message}`);
    return result;
  }

  /** @param {string} url */
  navigate(url) {
    return this.ask("browsingContext.navigate", { context: this.context, url, wait: "complete" });
  }

  /** @param {string} expression */
  async evaluate(expression) {
    const target = { context: this.context };
    const told = await this.ask("script.evaluate", { expression, target, awaitPromise: true });
    if (told.type === "exception") throw new Error(told.exceptionDetails.text);
    return told.result;
  }

  /** Answers go as JSON, as in the other protocol. @param {string} script */
  async run(script) {
    const { value } = await this.evaluate(`(async () => {${script}\n})().then((got) => JSON.stringify(got))`);
    return value === undefined ? null : JSON.parse(value);
  }

  /** @param {object[]} actions */
  perform(actions) {
    return this.ask("input.performActions", { context: this.context, actions });
  }

  /** @param {string} selector @param {string} file */
  async choose(selector, file) {
    const { sharedId } = await this.evaluate(`document.querySelector(${JSON.stringify(selector)})`);
    const { context } = this;
    await this.ask("input.setFiles", { context, element: { sharedId }, files: [resolve(file)] });
  }

  async close() {
    const ended = new Promise((go) => this.process.once("exit", go));
    this.socket?.close();
    if (this.process.kill()) await ended;
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}
