// @ts-check
// The module in Node: the fingerprints of long flights are those of this machine's own code.
//
//     node web/tests/bits.mjs MODULE.wasm.gz FINGERPRINTS

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { gunzipSync } from "node:zlib";

const [module, fingerprints] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(gunzipSync(readFileSync(module)), {});
const { memory, input, ask, output } = /** @type {any} */ (instance.exports);

/** @param {unknown} request */
function answer(request) {
  const question = new TextEncoder().encode(JSON.stringify(request));
  const at = input(question.length);
  new Uint8Array(memory.buffer, at, question.length).set(question);
  const length = ask();
  return JSON.parse(new TextDecoder().decode(new Uint8Array(memory.buffer, output(), length)));
}

const begun = Date.now();
const lines = readFileSync(fingerprints, "utf8").trim().split("\n");
assert.equal(lines.length, 12, "six presets and two scenarios");
for (const line of lines) {
  const [preset, scenario, expected] = line.split(" ");
  const { ok } = answer({ fingerprint: { preset, scenario, ticks: 1_000_000 } });
  assert.equal(ok, expected, `${preset}, scenario ${scenario}`);
}
const seconds = (Date.now() - begun) / 1000;
console.log(
  `${lines.length} flights of 1,000,000 ticks have this machine's bits, ` +
    `${(12_000 / seconds).toFixed(0)} times real time`,
);
