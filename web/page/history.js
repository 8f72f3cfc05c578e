// @ts-check
// The last minute of samples, a typed array for each column, so that a plot takes a window without copying.

/** Rows that are kept: 60 s at 200 a second. */
const KEPT = 12_000;

export class History {
  /** @param {string[]} names of the columns */
  constructor(names) {
    this.names = names;
    this.columns = names.map(() => new Float64Array(2 * KEPT));
    this.begin = 0;
    this.end = 0;
    /** @type {Map<string, number>} */
    this.place = new Map(names.map((name, index) => [name, index]));
  }

  /** Takes rows of samples. @param {Float32Array} rows */
  take(rows) {
    const width = this.names.length;
    for (let row = 0; row < rows.length; row += width) {
      if (this.end === 2 * KEPT) this.makeRoom();
      for (let column = 0; column < width; column += 1) this.columns[column][this.end] = rows[row + column];
      this.end += 1;
      this.begin = Math.max(this.begin, this.end - KEPT);
    }
  }

  makeRoom() {
    for (const column of this.columns) column.copyWithin(0, this.begin, this.end);
    this.end -= this.begin;
    this.begin = 0;
  }

  clear() {
    this.begin = 0;
    this.end = 0;
  }

  get length() {
    return this.end - this.begin;
  }

  /**
   * The first row at or after a time.
   * @param {number} time
   * @returns {number}
   */
  at(time) {
    const times = this.columns[0];
    let [low, high] = [this.begin, this.end];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** @returns {[number, number]} first and last time */
  span() {
    if (this.length === 0) return [0, 0];
    return [this.columns[0][this.begin], this.columns[0][this.end - 1]];
  }

  /**
   * The columns of these names between two times.
   * @param {string[]} names
   * @param {number} from
   * @param {number} to
   * @returns {Float64Array[]}
   */
  window(names, from, to) {
    const [first, last] = [this.at(from), Math.min(this.at(to) + 1, this.end)];
    return names.map((name) => this.column(name).subarray(first, last));
  }

  /** @param {string} name @returns {Float64Array} */
  column(name) {
    const place = this.place.get(name);
    if (place === undefined) throw new Error(`there is no column ${name}`);
    return this.columns[place];
  }

  /**
   * A row by name, the one at that time or the last.
   * @param {number} [time]
   * @returns {Record<string, number> | undefined}
   */
  row(time) {
    if (this.length === 0) return undefined;
    const at = time === undefined ? this.end - 1 : Math.min(this.at(time), this.end - 1);
    return Object.fromEntries(this.names.map((name, index) => [name, this.columns[index][at]]));
  }
}
