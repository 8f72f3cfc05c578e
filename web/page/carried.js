// @ts-check
// What a page from a file carries in itself, packed.

import { septets } from "./septets.js";

/** The bytes under an id; nothing in a page that is served. @param {string} id */
export async function carried(id) {
  const packed = document.getElementById(id)?.textContent ?? "";
  if (packed === "") return undefined;
  const unpacked = new Blob([septets(packed)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

/** The same as text. @param {string} id */
export async function carriedText(id) {
  return new TextDecoder().decode(await carried(id));
}
