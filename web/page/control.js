// @ts-check
// Which page controls a board that a program has: one does, others look on until they take over. Whoever does
// not see the board does not fly it: a page that is hidden, or closed, switches the motors off, and one that
// shows a record looks on.

import { button, byId } from "./dom.js";

/** @typedef {import("./socket.js").Socket} Socket */

export class Control {
  /**
   * @param {Socket} socket
   * @param {import("./attempt.js").Attempt} attempt
   * @param {() => void} stop switches the motors off
   */
  constructor(socket, attempt, stop) {
    this.socket = socket;
    socket.changed = () => this.show();
    button("take").addEventListener("click", () => attempt(() => socket.takeOver()));
    document.addEventListener("visibilitychange", () => {
      if (document.visibilityState === "hidden" && socket.controls) stop();
    });
    this.show();
  }

  show() {
    const { open, controls, controlled } = this.socket;
    const record = document.body.dataset.record !== undefined;
    // A program that is reached again gives control to whoever comes.
    if (controls && record) this.socket.lookAway().catch(() => {});
    byId("control").hidden = open && (controls || record);
    byId("control-told").textContent = open
      ? controlled
        ? "another page controls this board; you look on"
        : "nobody controls this board: the page that did has gone, or shows a record"
      : "the program cannot be reached, and with it the board: look whether host-sim monitor still runs";
    button("take").hidden = !open;
    document.body.dataset.looks = `${open && !controls}`;
    if (open) return;
    byId("state").textContent = "no answer";
    byId("state").dataset.state = "fault";
  }
}
