// @ts-check
// Bytes out of text, as `host-sim/src/page/septets.rs` writes it: seven bits in each character.

/** What the characters from U+0100 on stand for. */
const FORBIDDEN = [0, 13, 60];

/** @param {string} text @returns {Uint8Array<ArrayBuffer>} */
export function septets(text) {
  const bytes = new Uint8Array(Math.floor((text.length * 7) / 8));
  let [bits, count, at] = [0, 0, 0];
  for (let k = 0; k < text.length; k += 1) {
    const code = text.charCodeAt(k);
    bits = ((bits << 7) & 0x7fff) | (code < 128 ? code : FORBIDDEN[code - 256]);
    count += 7;
    if (count < 8) continue;
    count -= 8;
    bytes[at] = (bits >> count) & 0xff;
    at += 1;
  }
  return bytes;
}
