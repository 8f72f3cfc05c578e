// @ts-check
// The one script of a page from a file that is not packed: it unpacks the others, in their order.

import { carriedText } from "./carried.js";

async function boot() {
  for (const [id, type] of [
    ["uplot", "text/javascript"],
    ["app", "module"],
  ]) {
    const script = document.createElement("script");
    script.type = type;
    script.textContent = await carriedText(id);
    document.head.append(script);
  }
}

boot().catch((error) => {
  const told = document.getElementById("told");
  if (told) told.textContent = `The page could not begin: ${error}. A browser from 2023 or later opens it.`;
});
