// @ts-check
// 4 x 4 matrices in WebGL's order, column by column: what a drawing needs and no more.

/** @typedef {Float32Array} Matrix */

/** @param {...number} numbers @returns {Matrix} */
function matrix(...numbers) {
  return new Float32Array(numbers);
}

/** @param {Matrix} a @param {Matrix} b @returns {Matrix} */
function product(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 4; row += 1) {
      let sum = 0;
      for (let k = 0; k < 4; k += 1) sum += a[4 * k + row] * b[4 * column + k];
      out[4 * column + row] = sum;
    }
  }
  return out;
}

/** From left to right. @param {...Matrix} all @returns {Matrix} */
export function chain(...all) {
  return all.reduce(product);
}

/** @param {number} x @param {number} y @param {number} z @returns {Matrix} */
export function move(x, y, z) {
  return matrix(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1);
}

/** @param {number} x @param {number} y @param {number} z @returns {Matrix} */
export function stretch(x, y, z) {
  return matrix(x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1);
}

/** About the x axis. @param {number} angle in rad @returns {Matrix} */
export function aboutX(angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return matrix(1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, 0, 1);
}

/** About the y axis. @param {number} angle in rad @returns {Matrix} */
export function aboutY(angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return matrix(c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1);
}

/** About the z axis. @param {number} angle in rad @returns {Matrix} */
export function aboutZ(angle) {
  const [s, c] = [Math.sin(angle), Math.cos(angle)];
  return matrix(c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1);
}

/** @param {number} height of the view in rad @param {number} aspect @returns {Matrix} */
export function perspective(height, aspect) {
  const f = 1 / Math.tan(height / 2);
  const [near, far] = [0.1, 50];
  const depth = 1 / (near - far);
  return matrix(
    f / aspect,
    0,
    0,
    0,
    0,
    f,
    0,
    0,
    0,
    0,
    (far + near) * depth,
    -1,
    0,
    0,
    2 * far * near * depth,
    0,
  );
}
