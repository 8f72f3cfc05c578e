// @ts-check
// Whether people with other eyes and hands can use the page: axe-core finds nothing serious, in light and in
// dark, on a desk and on a phone, with every part unfolded.
//
//     node web/tests/axe.mjs heli.html AXE.min.js

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Chromium } from "./chromium.mjs";

const [page, axe] = process.argv.slice(2);
const browser = await Chromium.start();
try {
  await browser.open(pathToFileURL(resolve(page)).href);
  await browser.run(readFileSync(axe, "utf8"));
  await browser.run("for (const part of document.querySelectorAll('details')) part.open = true");
  for (const [width, height, dark] of /** @type {[number, number, boolean][]} */ ([
    [1280, 800, false],
    [1280, 800, true],
    [390, 844, false],
  ])) {
    await browser.size(width, height, dark);
    const found = await browser.value(`axe.run().then(({ violations }) => violations
      .filter(({ impact }) => impact === "serious" || impact === "critical")
      .map(({ id, nodes }) => id + ": " + nodes.map(({ target }) => target.join(" ")).join(", ")))`);
    assert.deepEqual(found, [], `${width} x ${height}${dark ? ", dark" : ""}`);
  }
  console.log("axe-core finds nothing serious");
} finally {
  await browser.close();
}
