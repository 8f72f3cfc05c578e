// @ts-check
// Which page controls a board that a program has: one does, others look on until they take over. Whoever does
// not see the board does not fly it: a page that is hidden, or closed, switches the motors off.

import { button, byId, input } from "./dom.js";

/** @typedef {import("./socket.js").Socket} Socket */

/** What becomes of a recorded flight here: its picture would stand where a board is that flies. */
const RECORDS =
  "a record would hide the board: write the page by itself with `host-sim page --out heli.html`, open it " +
  "beside this one, and open the record there";

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
    const refuse = () => attempt(() => Promise.reject(new Error(RECORDS)));
    const record = input("record");
    record.addEventListener("change", () => {
      record.value = "";
      refuse();
    });
    // Without this the browser would leave the page for the file.
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      refuse();
    });
    this.show();
  }

  show() {
    const { open, controls, controlled } = this.socket;
    byId("control").hidden = open && controls;
    byId("control-told").textContent = open
      ? controlled
        ? "another page controls this board; you look on"
        : "nobody controls this board: the page that did has gone"
      : "the program cannot be reached, and with it the board: look whether host-sim monitor still runs";
    button("take").hidden = !open;
    document.body.dataset.looks = `${open && !controls}`;
    if (open) return;
    byId("state").textContent = "no answer";
    byId("state").dataset.state = "fault";
  }
}
