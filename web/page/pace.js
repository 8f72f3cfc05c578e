// @ts-check
// How much is drawn, by how late frames are: a machine that draws by software gives up the 3-D picture's
// sharpness and rate first, then the plots' rate, so that what the board says and the stop stay quick.

/**
 * `part` of the 3-D picture's pixels in each direction, drawn in every so many `frames`; ms between `plots`.
 * @typedef {{ part: number, frames: number, plots: number }} Level
 */
/** From all there is to the least. @type {Level[]} */
const LEVELS = [
  { part: 1, frames: 1, plots: 30 },
  { part: 0.5, frames: 2, plots: 30 },
  { part: 0.25, frames: 4, plots: 30 },
  { part: 0.25, frames: 8, plots: 60 },
  { part: 0.25, frames: 8, plots: 120 },
];
/** Frames are judged for so long, in ms. */
const JUDGED = 1000;
/** Mean ms between two frames: above the one a level less is drawn, below the other more is tried. */
const [LATE, QUICK] = [40, 25];
/** Quick seconds in a row before more is tried; twice as many each time it was too much, up to the most. */
const [PATIENCE, MOST_PATIENCE] = [4, 64];

export class Pace {
  constructor() {
    this.at = 0;
    this.count = 0;
    this.frames = 0;
    this.quick = 0;
    this.patience = PATIENCE;
    /** More was tried in the second before. */
    this.tried = false;
    /** @type {number | undefined} */
    this.begun = undefined;
  }

  /** @returns {Level} */
  get level() {
    return LEVELS[this.at];
  }

  /** A frame begins: is the 3-D picture drawn in it? @param {number} now in ms */
  frame(now) {
    this.count += 1;
    this.begun ??= now;
    const passed = now - this.begun;
    if (passed >= JUDGED) {
      this.judge(passed / this.frames);
      [this.begun, this.frames] = [now, 0];
    }
    this.frames += 1;
    return this.count % this.level.frames === 0;
  }

  /** @param {number} mean ms between two frames of the last second */
  judge(mean) {
    this.quick = mean < QUICK ? this.quick + 1 : 0;
    if (mean > LATE) {
      if (this.tried) this.patience = Math.min(2 * this.patience, MOST_PATIENCE);
      this.at = Math.min(this.at + 1, LEVELS.length - 1);
    }
    this.tried = false;
    if (this.quick < this.patience || this.at === 0) return;
    [this.at, this.quick, this.tried] = [this.at - 1, 0, true];
  }

  /** Nobody looked: the time until now says nothing. */
  forget() {
    this.begun = undefined;
    this.frames = 0;
  }
}
