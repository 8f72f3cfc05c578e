// @ts-check
// Short ways to the document.

/**
 * The element of this id, which the page has.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found;
}

/** @param {string} id @returns {HTMLButtonElement} */
export function button(id) {
  return /** @type {HTMLButtonElement} */ (byId(id));
}

/** @param {string} id @returns {HTMLInputElement} */
export function input(id) {
  return /** @type {HTMLInputElement} */ (byId(id));
}

/** @param {string} id @returns {HTMLSelectElement} */
export function select(id) {
  return /** @type {HTMLSelectElement} */ (byId(id));
}

/**
 * A new element.
 * @param {string} tag
 * @param {Record<string, string>} [attributes]
 * @param {...(Node | string)} children
 * @returns {HTMLElement}
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/**
 * Fills a list of choices.
 * @param {string} id
 * @param {string[]} names
 */
export function choices(id, names) {
  byId(id).replaceChildren(...names.map((name) => make("option", { value: name }, name)));
}

/** Colours asked for so far: asking the style sheet takes time. @type {Map<string, string>} */
const colours = new Map();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => colours.clear());

/** A colour of the style sheet. @param {string} name @returns {string} */
export function colour(name) {
  const known = colours.get(name);
  if (known !== undefined) return known;
  const found = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  colours.set(name, found);
  return found;
}

/**
 * Offers a text as a file.
 * @param {string} name
 * @param {string[]} parts of it
 */
export function download(name, parts) {
  const url = URL.createObjectURL(new Blob(parts, { type: "text/plain" }));
  const anchor = /** @type {HTMLAnchorElement} */ (make("a", { href: url, download: name }));
  anchor.click();
  URL.revokeObjectURL(url);
}
