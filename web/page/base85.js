// @ts-check
// Bytes out of text, as `host-sim/src/page/base85.rs` writes it: four of them in five characters.

/** @param {string} text @returns {Uint8Array<ArrayBuffer>} */
export function read85(text) {
  const length = Math.floor((text.length * 4) / 5);
  const bytes = new Uint8Array(length + 4);
  const view = new DataView(bytes.buffer);
  for (let group = 0; 5 * group < text.length; group += 1) {
    let value = 0;
    for (let k = 5 * group; k < 5 * group + 5; k += 1) {
      const code = k < text.length ? text.charCodeAt(k) : 119;
      value = 85 * value + (code === 120 ? 60 : code) - 35;
    }
    view.setUint32(4 * group, value);
  }
  return bytes.subarray(0, length);
}
