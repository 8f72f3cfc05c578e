// @ts-check
// The helicopter in three dimensions: pitch, yaw and rotor speeds as they are, a ghost where it should be, and
// rotors that show when their motors are asked for more than they give. Dragging it is a hand at the rig.

import { byId, colour } from "./dom.js";
import { aboutX, aboutY, aboutZ, chain, move, perspective, stretch } from "./matrix.js";
import { box, disc, ring, tube } from "./mesh.js";

/** @typedef {import("./matrix.js").Matrix} Matrix */
/** @typedef {"box" | "disc" | "ring" | "tube"} Shape */

const VERTEX = `#version 300 es
layout(location = 0) in vec3 place; layout(location = 1) in vec3 normal;
uniform mat4 view; uniform mat4 model; out vec3 n;
void main() { n = mat3(model) * normal; gl_Position = view * model * vec4(place, 1.0); }`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec3 n; uniform vec4 tint; out vec4 shown;
void main() {
  float lit = 0.55 + 0.45 * abs(dot(normalize(n), normalize(vec3(0.4, 1.0, 0.6))));
  shown = vec4(tint.rgb * lit, tint.a);
}`;
const DEGREE = Math.PI / 180;
/** Turns a second that a rotor seems to make for each volt: slow enough to be seen. */
const SEEN_TURNS = 0.25;
/** Volts at a motor for each pixel that the rig is dragged. */
const VOLTS_PER_PIXEL = 0.06;

export class Helicopter {
  /** @param {(push: { main: number, tail: number }) => void} push */
  constructor(push) {
    this.canvas = /** @type {HTMLCanvasElement} */ (byId("helicopter"));
    this.turned = { main: 0, tail: 0 };
    /** @type {number | undefined} */
    this.before = undefined;
    // Smooth edges where a card draws them: by software they block the page for 50 ms a frame.
    const gl =
      this.canvas.getContext("webgl2", { antialias: true, failIfMajorPerformanceCaveat: true }) ??
      this.canvas.getContext("webgl2", { antialias: false });
    byId("no-webgl").hidden = gl !== null;
    this.gl = gl;
    if (gl) this.prepare(gl);
    this.drag(push);
  }

  /** @param {WebGL2RenderingContext} gl */
  prepare(gl) {
    const program = gl.createProgram();
    for (const [kind, source] of /** @type {[number, string][]} */ ([
      [gl.VERTEX_SHADER, VERTEX],
      [gl.FRAGMENT_SHADER, FRAGMENT],
    ])) {
      const shader = gl.createShader(kind);
      if (!shader) return;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    gl.useProgram(program);
    this.uniforms = {
      view: gl.getUniformLocation(program, "view"),
      model: gl.getUniformLocation(program, "model"),
      tint: gl.getUniformLocation(program, "tint"),
    };
    /** @type {Record<Shape, { array: WebGLVertexArrayObject | null, count: number }>} */
    this.shapes = {
      box: store(gl, box()),
      disc: store(gl, disc(40)),
      ring: store(gl, ring(40)),
      tube: store(gl, tube(24)),
    };
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  /**
   * @param {Record<string, number>} row of samples @param {number} now in ms
   * @param {number} part of the pixels that there are, in each direction
   */
  draw(row, now, part) {
    const passed = this.before === undefined ? 0 : Math.min((now - this.before) / 1000, 1);
    this.before = now;
    // Of a rig that is not simulated nobody knows what is in effect at the rotors, but what the motors get.
    const turns = (/** @type {number} */ known, /** @type {number} */ given) =>
      passed * SEEN_TURNS * 2 * Math.PI * (Number.isNaN(known) ? given : known);
    this.turned.main += turns(row.main_rotor, row.main_volts);
    this.turned.tail += turns(row.tail_rotor, row.tail_volts);
    const { gl, canvas } = this;
    if (!gl) return;
    const scale = part * Math.min(devicePixelRatio, 2);
    const [width, height] = [canvas.clientWidth * scale, canvas.clientHeight * scale].map(Math.round);
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const view = chain(perspective(0.62, width / height), move(0, 0.12, -4.2), aboutX(0.38), aboutY(-0.55));
    gl.uniformMatrix4fv(this.uniforms?.view ?? null, false, view);
    const metal = tint("metal");
    this.part("tube", chain(move(0, -1, 0), stretch(0.05, 1, 0.05)), metal);
    this.part("disc", chain(move(0, -1, 0), stretch(0.55, 1, 0.55)), metal);
    this.part("ring", chain(move(0, -0.995, 0), stretch(0.9, 1, 0.9)), tint("line"));
    const clipped = { main: (row.clipped & 1) !== 0, tail: (row.clipped & 2) !== 0 };
    this.body(row.pitch, row.yaw, 1, clipped);
    this.body(row.pitch_reference, row.yaw_reference, 0.22, { main: false, tail: false });
    byId("clipped").textContent = [clipped.main && "main", clipped.tail && "tail"]
      .filter(Boolean)
      .join(" and ");
  }

  /**
   * The arm with both rotors; `opacity` below 1 is the ghost.
   * @param {number} pitch @param {number} yaw in degrees @param {number} opacity
   * @param {{ main: boolean, tail: boolean }} clipped
   */
  body(pitch, yaw, opacity, clipped) {
    // Nose up is positive; so is yaw against the clock, seen from above.
    const place = chain(aboutY(yaw * DEGREE), aboutZ(pitch * DEGREE));
    const see = (/** @type {string} */ name) => tint(name, opacity);
    this.part("box", chain(place, stretch(1.9, 0.06, 0.06)), see("metal"));
    this.part("box", chain(place, stretch(0.22, 0.13, 0.13)), see("body"));
    this.rotor(chain(place, move(0.98, 0.05, 0)), "main", clipped.main, see);
    this.rotor(
      chain(place, move(-0.98, 0, 0), aboutX(Math.PI / 2), move(0, 0.05, 0)),
      "tail",
      clipped.tail,
      see,
    );
  }

  /**
   * @param {Matrix} place @param {"main" | "tail"} which @param {boolean} clipped
   * @param {(name: string) => number[]} see
   */
  rotor(place, which, clipped, see) {
    const shown = see(clipped ? "stop" : which);
    this.part("box", chain(place, stretch(0.1, 0.14, 0.1)), see("body"));
    this.part("ring", chain(place, move(0, 0.07, 0), stretch(0.4, 1, 0.4)), shown);
    for (const blade of [0, Math.PI / 2]) {
      const turned = chain(place, move(0, 0.07, 0), aboutY(this.turned[which] + blade));
      this.part("box", chain(turned, stretch(0.74, 0.015, 0.07)), shown);
    }
  }

  /** @param {Shape} shape @param {Matrix} model @param {number[]} tinted */
  part(shape, model, tinted) {
    const { gl, shapes, uniforms } = this;
    if (!gl || !shapes || !uniforms) return;
    gl.uniformMatrix4fv(uniforms.model, false, model);
    gl.uniform4fv(uniforms.tint, tinted);
    gl.bindVertexArray(shapes[shape].array);
    gl.drawArrays(gl.TRIANGLES, 0, shapes[shape].count);
  }

  /** @param {(push: { main: number, tail: number }) => void} push */
  drag(push) {
    /** @type {{ x: number, y: number } | undefined} */
    let held;
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => {
      held = { x: event.clientX, y: event.clientY };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      const main = (held.y - event.clientY) * VOLTS_PER_PIXEL;
      push({ main, tail: (event.clientX - held.x) * VOLTS_PER_PIXEL });
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, () => {
        held = undefined;
        push({ main: 0, tail: 0 });
      });
    }
  }
}

/** @param {WebGL2RenderingContext} gl @param {Float32Array} triangles */
function store(gl, triangles) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
  for (const place of [0, 1]) {
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, 12 * place);
  }
  return { array, count: triangles.length / 6 };
}

/** A colour of the style sheet, `#rrggbb` there. @param {string} name @param {number} opacity */
function tint(name, opacity = 1) {
  const number = parseInt(colour(name).slice(1), 16);
  return [(number >> 16) & 255, (number >> 8) & 255, number & 255].map((part) => part / 255).concat(opacity);
}
