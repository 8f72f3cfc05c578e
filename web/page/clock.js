// @ts-check
// How simulated time passes: real time, slower, faster, or a tick at a time. In a tab that nobody sees it
// stands still, board and operator alike, and goes on from there.

/** Most that one drawn frame makes good, in ms: a machine that slept does not owe the night. */
const MOST_LATE = 250;

export class Clock {
  /** @param {(ticks: number) => void} pass lets ticks pass @param {() => void} draw */
  constructor(pass, draw) {
    this.pass = pass;
    this.draw = draw;
    this.speed = 1;
    this.running = true;
    this.owed = 0;
    /** @type {number | undefined} */
    this.before = undefined;
    this.frame = this.frame.bind(this);
  }

  start() {
    requestAnimationFrame(this.frame);
  }

  /** @param {number} now in ms */
  frame(now) {
    const passed = this.before === undefined ? 0 : Math.min(now - this.before, MOST_LATE);
    this.before = now;
    if (this.running) {
      this.owed += passed * this.speed;
      const ticks = Math.floor(this.owed);
      this.owed -= ticks;
      if (ticks > 0) this.pass(ticks);
    }
    this.draw();
    requestAnimationFrame(this.frame);
  }

  /** One tick while it stands. */
  step() {
    this.running = false;
    this.pass(1);
  }
}
