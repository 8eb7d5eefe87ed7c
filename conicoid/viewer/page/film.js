// The picture in work: one sample after the other at rest, in bands that keep the page alive; coarse while it moves.
import { lens } from "./camera.js";

const MOST_SAMPLES = 64;
const REST = 140;        // ms without a change: the picture is at rest
const BAND = 24;         // ms of work at a time
const SMOOTH = 26;       // ms for a frame in motion

export class Film {
  // view() -> { camera, section, xray, chordScale, softness, depth }; `on` { may(), first(), failed(error) }: whether work
  // may begin, and calls when the first frame is on the screen and when the scene cannot be drawn
  constructor(graphics, view, on) {
    this.graphics = graphics;
    this.view = view;
    this.on = on;
    this.scale = 0.5;
    this.rate = 300;     // pixels per millisecond, as measured; a guess that no browser stalls on
    this.frames = [null, null];
    this.most = MOST_SAMPLES;
    this.samples = 0;
    this.row = 0;
    this.changedAt = -1e9;
    this.moving = false;
    this.waiting = null; // a fence, its pixels and when they were asked for
    this.done = [];
    this.first = null;   // a fence behind the first frame; true when that is on the screen
    this.compiling = 0;  // since when the driver has been compiling; 0 when it is not
    const gl = graphics.gl;
    this.smooth = Boolean(gl.getExtension("OES_texture_float_linear"));
    this.tick = this.tick.bind(this);
    this.asked = false;
  }

  // Something that is seen has changed; `moving`: it will again soon
  changed(moving = false) {
    this.changedAt = performance.now();
    this.moving = moving;
    this.samples = 0;
    this.row = 0;
    this.fresh = true;
    this.wake();
  }

  wake() {
    if (!this.asked) { this.asked = true; requestAnimationFrame(this.tick); }
  }

  // A promise of a picture of at least so many samples
  settled(samples = 1) {
    this.wake();
    return new Promise((resolve) => this.done.push([samples, resolve]));
  }

  size() {
    const canvas = this.graphics.canvas;
    return [canvas.width, canvas.height];
  }

  finished() {
    if (!this.waiting) return true;
    const gl = this.graphics.gl, status = gl.clientWaitSync(this.waiting.fence, 0, 0);
    if (status === gl.TIMEOUT_EXPIRED) return false;
    const spent = Math.max(0.3, performance.now() - this.waiting.since);
    this.rate = 0.5 * this.rate + (0.5 * this.waiting.pixels) / spent;
    if (this.waiting.moving) {
      if (spent > SMOOTH * 1.2) this.scale = Math.max(0.1, this.scale * Math.max(0.5, Math.sqrt(SMOOTH / spent)));
      else if (spent < SMOOTH * 0.5) this.scale = Math.min(1, this.scale * 1.15);
    }
    gl.deleteSync(this.waiting.fence);
    this.waiting = null;
    return true;
  }

  // How much of the first frame is there, from 0 to 1
  get share() { return this.row / Math.max(1, this.size()[1]); }

  tick() {
    this.asked = false;
    if (this.graphics.gl.isContextLost()) return;
    try { this.work(); } catch (error) { this.on.failed(error); }
  }

  // Whether the shaders are compiled; what the browser shows stands still while some drivers do that
  ready() {
    if (!this.on.may()) return false;
    const ready = ["picture", "show"].map((name) => this.graphics.ready(name)).every(Boolean);
    this.compiling = ready ? 0 : this.compiling || performance.now();
    return ready;
  }

  work() {
    if (!this.ready() || !this.finished()) return this.wake();
    this.noteFirst();
    const atRest = !this.moving || performance.now() - this.changedAt > REST;
    if (!atRest) {
      if (this.fresh) this.frameInMotion();
      return this.wake();
    }
    if (this.moving) { this.moving = false; this.samples = 0; this.row = 0; }
    // The work before is done: who waits for so many samples has them, before the next band is begun
    const most = this.graphics.floatFilm ? this.most : 1;
    this.done = this.done.filter(([samples, resolve]) => {
      const ready = this.samples >= Math.min(samples, most);
      if (ready) resolve(this.samples);
      return !ready;
    });
    this.band();
    if (this.samples < most || this.waiting || this.done.length || this.first !== true) this.wake();
  }

  noteFirst() {
    const gl = this.graphics.gl;
    if (!this.first || this.first === true || gl.clientWaitSync(this.first, 0, 0) === gl.TIMEOUT_EXPIRED) return;
    gl.deleteSync(this.first);
    this.first = true;
    this.on.first();
  }

  frame(slot, width, height) {
    const gl = this.graphics.gl, old = this.frames[slot];
    if (old && old.width === width && old.height === height) return old;
    const frame = old ?? { texture: gl.createTexture(), buffer: gl.createFramebuffer() };
    Object.assign(frame, { width, height, samples: 0 });
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, frame.texture);
    const [format, type] = this.graphics.floatFilm ? [this.smooth ? gl.RGBA32F : gl.RGBA16F, gl.FLOAT] : [gl.RGBA8, gl.UNSIGNED_BYTE];
    gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, null);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.LINEAR);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, frame.texture, 0);
    this.frames[slot] = frame;
    return frame;
  }

  // Draw rows of one sample of a picture into a frame
  trace(frame, before, sample, row, rows) {
    const gl = this.graphics.gl, view = this.view();
    const at = this.graphics.use("picture", lens(view.camera), frame.width, frame.height, view.section);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, before ? before.texture : null);
    gl.uniform1i(at("u_sample"), sample);
    gl.uniform1i(at("u_xray"), view.xray ? 1 : 0);
    gl.uniform1f(at("u_chord_scale"), view.chordScale);
    gl.uniform1f(at("u_softness"), view.softness);
    gl.uniform1i(at("u_depth"), Math.min(view.depth, this.graphics.sizes.RAYS - 2));
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame.buffer);
    gl.viewport(0, 0, frame.width, frame.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, row, frame.width, rows);
    const since = performance.now();
    this.graphics.draw();
    gl.disable(gl.SCISSOR_TEST);
    this.waiting = { fence: gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), pixels: frame.width * rows, since, moving: this.moving };
    gl.flush();
  }

  frameInMotion() {
    const [width, height] = this.size();
    const frame = this.frame(0, Math.max(1, Math.round(width * this.scale)), Math.max(1, Math.round(height * this.scale)));
    this.trace(frame, null, 0, 0, frame.height);
    frame.samples = 1;
    this.fresh = false;
    this.show(frame);
  }

  band() {
    const [width, height] = this.size();
    if (this.samples >= this.most || width < 1 || height < 1) return;
    const slot = this.samples % 2, frame = this.frame(slot + 1, width, height);
    const before = this.samples > 0 ? this.frames[2 - slot] : null;
    const rows = Math.min(frame.height - this.row, Math.max(1, Math.round((BAND * this.rate) / width)));
    this.trace(frame, before, this.samples, this.row, rows);
    this.row += rows;
    if (this.row < frame.height) return;
    this.row = 0;
    this.samples++;
    frame.samples = this.samples;
    this.show(frame);
  }

  show(frame) {
    const gl = this.graphics.gl, made = this.graphics.program("show"), [width, height] = this.size();
    this.shown = frame;
    gl.useProgram(made.program);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, frame.texture);
    gl.uniform1i(made.uniforms.get("u_film"), 2);
    gl.uniform1f(made.uniforms.get("u_samples"), frame.samples);
    gl.uniform2f(made.uniforms.get("u_screen_size"), width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    this.graphics.draw();
    this.first ??= gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  }

  // Mean linear light of what is shown, rows from the bottom, four numbers a pixel
  read() {
    const gl = this.graphics.gl, frame = this.shown, values = new Float32Array(4 * frame.width * frame.height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame.buffer);
    gl.readPixels(0, 0, frame.width, frame.height, gl.RGBA, gl.FLOAT, values);
    return { width: frame.width, height: frame.height, values: values.map((v) => v / frame.samples) };
  }
}
