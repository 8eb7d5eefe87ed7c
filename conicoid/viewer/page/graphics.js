// WebGL 2: shaders, textures, and what this machine's limits allow.
import { packedFloats, packedIntegers, shaderSizes } from "./tables.js";

const VERTEX = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;
const TEXTURE_SHIFT = 11;

export const NO_WEBGL = "This browser offers no WebGL 2. Current versions of Chrome, Edge, Firefox and Safari have it, unless hardware "
  + "acceleration is switched off in their settings or the graphics driver is on their list of broken ones.";
export const GAVE_UP = "The graphics driver gave up on the shader of this scene. Loading the page again, or another browser, may help.";

export class LimitError extends Error {}

export class Graphics {
  constructor(canvas, sources) {
    this.canvas = canvas;
    this.sources = sources;
    const options = { antialias: false, alpha: false, depth: false, preserveDrawingBuffer: true, powerPreference: "high-performance" };
    this.gl = canvas.getContext("webgl2", options);
    if (!this.gl) throw new LimitError(NO_WEBGL);
    this.floatFilm = Boolean(this.gl.getExtension("EXT_color_buffer_float"));
    this.parallel = this.gl.getExtension("KHR_parallel_shader_compile");
    this.programs = new Map();
    this.gl.bindVertexArray(this.gl.createVertexArray());
  }

  // The textures of a scene; `styles` says what is hidden and tinted
  load(scene, styles, origin) {
    this.scene = scene;
    this.sizes = shaderSizes(scene);
    this.restyle(styles);
    this.rebase(origin);
  }

  restyle(styles) {
    const gl = this.gl, packed = packedIntegers(this.scene, styles);
    this.place = packed.place;
    this.layout = packed.floats;
    this.ints = this.texture(this.ints, packed.records, gl.RGBA32I, gl.RGBA_INTEGER, gl.INT, "surfaces, cells and tree");
  }

  rebase(origin) {
    const gl = this.gl;
    this.origin = origin;
    this.floats = this.texture(this.floats, packedFloats(this.scene, this.layout, origin), gl.RGBA32F, gl.RGBA, gl.FLOAT, "coefficients");
  }

  texture(old, values, internal, format, type, what) {
    const gl = this.gl, width = 1 << TEXTURE_SHIFT, rows = Math.max(1, Math.ceil(values.length / 4 / width));
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (rows > most || width > most)
      throw new LimitError(`The ${what} of this scene take a texture of ${width} × ${rows}; MAX_TEXTURE_SIZE of this browser is ${most}.`);
    const padded = new values.constructor(4 * width * rows);
    padded.set(values);
    const texture = old ?? gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, rows, 0, format, type, padded);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
    if (gl.getError() === gl.OUT_OF_MEMORY) throw new LimitError(`There is no room on the GPU for the ${what} of this scene.`);
    return texture;
  }

  // Hand a program to the driver, which may compile it while the page goes on
  begun(name) {
    const gl = this.gl;
    const defines = { TEXTURE_WIDTH: 1 << TEXTURE_SHIFT, TEXTURE_SHIFT, ...(name === "show" ? {} : this.sizes) };
    const head = "#version 300 es\nprecision highp float;\nprecision highp int;\n"
      + Object.entries(defines).map(([key, value]) => `#define ${key} ${value}\n`).join("");
    const key = name + head;
    if (this.programs.has(key)) return this.programs.get(key);
    const program = gl.createProgram(), shaders = [];
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, head + this.sources[name].map((piece) => this.sources.pieces[piece]).join("\n")]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      shaders.push(shader);
    }
    gl.linkProgram(program);
    const made = { program, shaders, uniforms: null };
    this.programs.set(key, made);
    return made;
  }

  // Whether a program can be used at once; a driver that cannot say so is waited for when it is used
  ready(name) {
    const { program, uniforms } = this.begun(name);
    return Boolean(uniforms) || !this.parallel || this.gl.getProgramParameter(program, this.parallel.COMPLETION_STATUS_KHR);
  }

  program(name) {
    const gl = this.gl, made = this.begun(name), { program, shaders } = made;
    if (made.uniforms) return made;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      if (gl.isContextLost()) throw new LimitError(GAVE_UP);
      const log = shaders.map((s) => gl.getShaderInfoLog(s)).join("\n") + gl.getProgramInfoLog(program);
      throw new LimitError(`This browser's driver does not take the shader: ${log.slice(0, 2000)}`);
    }
    made.uniforms = new Map();
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const info = gl.getActiveUniform(program, i);
      made.uniforms.set(info.name.replace("[0]", ""), gl.getUniformLocation(program, info.name));
    }
    return made;
  }

  // Make a program current and give it the scene, the camera's lens and the section plane
  use(name, lens, width, height, section) {
    const gl = this.gl, made = this.program(name), at = (key) => made.uniforms.get(key) ?? null;
    gl.useProgram(made.program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.floats);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.ints);
    gl.uniform1i(at("u_floats"), 0);
    gl.uniform1i(at("u_ints"), 1);
    gl.uniform1i(at("u_film"), 2);
    gl.uniform1iv(at("u_place"), this.place);
    for (const [key, value] of [["u_boxes", "boxes"], ["u_vertices", "vertices"], ["u_materials", "materials"],
      ["u_lights", "lights"], ["u_frames", "frames"], ["u_tree", "tree"], ["u_root_list", "rootList"]])
      gl.uniform1i(at(key), this.layout[value]);
    const rows = lens.map((row, k) => (k === 0 ? row.map((v, i) => v - this.origin[i]) : row));
    gl.uniform3fv(at("u_lens"), rows.flat());
    gl.uniform2f(at("u_size"), width, height);
    gl.uniform1i(at("u_cuts"), section ? 1 : 0);
    if (section) {
      const [x, y, z] = section.normal, o = this.origin;
      gl.uniform4f(at("u_section"), x, y, z, section.offset - (x * o[0] + y * o[1] + z * o[2]));
    }
    gl.uniform3fv(at("u_ambient"), this.scene.look.ambient);
    gl.uniform3fv(at("u_sky"), this.scene.look.sky.flat());
    gl.uniform1i(at("u_light_count"), this.scene.lights.length);
    return at;
  }

  draw() { this.gl.drawArrays(this.gl.TRIANGLES, 0, 3); }
}
