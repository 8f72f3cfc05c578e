// @ts-check
// The shapes that the helicopter is made of, as triangles: three numbers of place and three of normal each.

/** A box from -1/2 to 1/2. @returns {Float32Array} */
export function box() {
  const out = [];
  for (const axis of [0, 1, 2]) {
    for (const side of [-0.5, 0.5]) {
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      const corners = [
        [-0.5, -0.5],
        [0.5, -0.5],
        [0.5, 0.5],
        [-0.5, -0.5],
        [0.5, 0.5],
        [-0.5, 0.5],
      ];
      for (const [a, b] of corners) {
        const place = [0, 0, 0];
        const normal = [0, 0, 0];
        [place[axis], place[u], place[v]] = [side, a, b];
        normal[axis] = 2 * side;
        out.push(...place, ...normal);
      }
    }
  }
  return new Float32Array(out);
}

/** A disc of radius 1 across the y axis. @param {number} corners @returns {Float32Array} */
export function disc(corners) {
  const out = [];
  for (let k = 0; k < corners; k += 1) {
    const [from, to] = [k, k + 1].map((n) => (2 * Math.PI * n) / corners);
    out.push(0, 0, 0, 0, 1, 0);
    out.push(Math.cos(from), 0, Math.sin(from), 0, 1, 0);
    out.push(Math.cos(to), 0, Math.sin(to), 0, 1, 0);
  }
  return new Float32Array(out);
}

/** A ring of outer radius 1 across the y axis. @param {number} corners @returns {Float32Array} */
export function ring(corners) {
  const out = [];
  const inner = 0.92;
  for (let k = 0; k < corners; k += 1) {
    const [from, to] = [k, k + 1].map((n) => (2 * Math.PI * n) / corners);
    const at = (/** @type {number} */ r, /** @type {number} */ a) => [
      r * Math.cos(a),
      0,
      r * Math.sin(a),
      0,
      1,
      0,
    ];
    out.push(...at(inner, from), ...at(1, from), ...at(1, to));
    out.push(...at(inner, from), ...at(1, to), ...at(inner, to));
  }
  return new Float32Array(out);
}

/** An upright tube of radius and height 1, open. @param {number} corners @returns {Float32Array} */
export function tube(corners) {
  const out = [];
  for (let k = 0; k < corners; k += 1) {
    const [from, to] = [k, k + 1].map((n) => (2 * Math.PI * n) / corners);
    const at = (/** @type {number} */ a, /** @type {number} */ y) => [
      Math.cos(a),
      y,
      Math.sin(a),
      Math.cos(a),
      0,
      Math.sin(a),
    ];
    out.push(...at(from, 0), ...at(to, 0), ...at(to, 1), ...at(from, 0), ...at(to, 1), ...at(from, 1));
  }
  return new Float32Array(out);
}
