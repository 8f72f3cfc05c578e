// @ts-check
// What a link carries: `#preset=aero2&controller=own&scenario=step`, so that a teacher can send one.

/** @returns {Map<string, string>} */
export function read() {
  return new Map(new URLSearchParams(location.hash.slice(1)));
}

/**
 * Keeps what is not as it begins in the address, without a step in the browser's history.
 * @param {Record<string, string | number | undefined>} state
 */
export function write(state) {
  const kept = Object.entries(state).filter(([, value]) => value !== undefined && value !== "");
  const hash = new URLSearchParams(kept.map(([name, value]) => [name, String(value)])).toString();
  history.replaceState(null, "", hash ? `#${hash}` : location.pathname + location.search);
}
