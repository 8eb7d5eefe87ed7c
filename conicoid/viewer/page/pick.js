// The crossings of one ray, asked of the shader.
import { lens } from "./camera.js";

const MOST = 64;

export class Picker {
  constructor(graphics) { this.graphics = graphics; }

  target() {
    const gl = this.graphics.gl;
    if (this.buffer) return this.buffer;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, MOST, 3);
    this.buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    return this.buffer;
  }

  // Up to `most` crossings behind a pixel, counted from the top left corner of the canvas
  at(view, x, y, width, height, most = 1) {
    const gl = this.graphics.gl, count = Math.min(most, MOST);
    const at = this.graphics.use("pick", lens(view.camera), width, height, view.section);
    gl.uniform2f(at("u_pixel"), Math.max(0, x), height - y);
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target());
    gl.viewport(0, 0, count, 3);
    this.graphics.draw();
    const words = new Uint32Array(4 * count * 3), floats = new Float32Array(words.buffer);
    gl.readPixels(0, 0, count, 3, gl.RGBA_INTEGER, gl.UNSIGNED_INT, words);
    const found = [], whole = new Int32Array(words.buffer);
    for (let k = 0; k < count && whole[4 * k + 1] >= 0; k++) {
      const n = 4 * (count + k), w = 4 * (2 * count + k);
      found.push({
        t: floats[4 * k], body: whole[4 * k + 1], face: whole[4 * k + 2], surface: whole[4 * k + 3],
        normal: [...floats.subarray(n, n + 3)], entering: words[n + 3] === 1, uv: [floats[w], floats[w + 1]],
      });
    }
    return found;
  }
}
