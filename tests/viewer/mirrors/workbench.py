"""Functions of the shaders on numbers: each input is a pixel, and its answers are floats of a texture.

The page's own modules put the shaders together and the tables of a scene into textures, so that the tests try these
too.
"""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np

from conicoid.viewer.html import PICK_SHADERS, SHADERS, script, shaders

PIECES = [name for name in SHADERS if name != "picture"]
assert set(PICK_SHADERS) - {"pick"} <= set(PIECES)

MAIN = """
uniform highp sampler2D u_inputs;
uniform ivec3 u_layout;    // inputs, records of each, pixels in a row
TARGETS
int input_at;
float answers[ANSWERS];
int answer_count;

// Record k of the input: four floats
vec4 given(int k) {
    int i = input_at + k;
    return texelFetch(u_inputs, ivec2(i % 2048, i / 2048), 0);
}

// The ray of records k to k + 2: origin and t_min, direction and t_max, the surface it starts on
Ray given_ray(int k) {
    vec4 a = given(k), b = given(k + 1);
    return Ray(a.xyz, b.xyz, max(-FAR, a.w), min(FAR, b.w), int(given(k + 2).x));
}

void put(float x) { answers[answer_count++] = x; }
void put(int x) { put(float(x)); }
void put(bool x) { put(x ? 1.0 : 0.0); }
void put(vec2 x) { put(x.x); put(x.y); }
void put(vec3 x) { put(x.xy); put(x.z); }
void put(vec4 x) { put(x.xyz); put(x.w); }
void put(ivec2 x) { put(vec2(x)); }
void put(ivec3 x) { put(vec3(x)); }

void case_() {
CASE
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int input_number = pixel.y * u_layout.z + pixel.x;
    for (int k = 0; k < ANSWERS; k++) answers[k] = 0.0;
    answer_count = 0;
    input_at = input_number * u_layout.y;
    if (input_number < u_layout.x) case_();
    FOURS
}
"""

PAGE = """
const bench = {
  sizes: {},
  // A scene about an origin; later runs are about it
  load(data, origin) {
    this.graphics ??= new Graphics(document.querySelector("canvas"), %(shaders)s);
    this.graphics.load(decodedScene(data), { hidden: new Set(), tints: new Map() }, origin);
    // One program serves all scenes that were loaded before it is made
    for (const [name, size] of Object.entries(this.graphics.sizes)) this.sizes[name] = Math.max(size, this.sizes[name] ?? 0);
  },
  floats(text) { return new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer); },
  text(floats) {
    const bytes = new Uint8Array(floats.buffer), parts = [];
    for (let i = 0; i < bytes.length; i += 8192) parts.push(String.fromCharCode(...bytes.subarray(i, i + 8192)));
    return btoa(parts.join(""));
  },
  run(name, source, sizes, inputs, count, records, answers, view) {
    const { graphics } = this, { gl, sources } = graphics, columns = 256, rows = Math.ceil(count / columns);
    if (!graphics.floatFilm) throw new Error("no EXT_color_buffer_float");
    sources.pieces[name] = source;
    sources[name] = %(pieces)s.concat(name);
    graphics.sizes = { ...this.sizes, ANSWERS: answers, ...sizes };
    const at = graphics.use(name, view.lens, ...view.size, view.section);
    gl.activeTexture(gl.TEXTURE3);
    const given = graphics.texture(null, this.floats(inputs), gl.RGBA32F, gl.RGBA, gl.FLOAT, "inputs");
    gl.uniform1i(at("u_inputs"), 3);
    gl.uniform3i(at("u_layout"), count, records, columns);
    gl.uniform1i(at("u_sample"), 0);
    const frame = gl.createFramebuffer(), targets = Array.from({ length: answers / 4 }, (_, k) => gl.COLOR_ATTACHMENT0 + k);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.activeTexture(gl.TEXTURE4);
    const textures = targets.map((target) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, columns, rows);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, target, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    gl.drawBuffers(targets);
    gl.viewport(0, 0, columns, rows);
    graphics.draw();
    const pixels = new Float32Array(4 * columns * rows * targets.length);
    targets.forEach((target, k) => {
      gl.readBuffer(target);
      gl.readPixels(0, 0, columns, rows, gl.RGBA, gl.FLOAT, pixels, 4 * columns * rows * k);
    });
    const error = gl.getError();
    if (error) throw new Error(`${name}: WebGL error ${error}`);
    for (const texture of [given, ...textures]) gl.deleteTexture(texture);
    gl.deleteFramebuffer(frame);
    return this.text(pixels);
  },
};
window.bench = bench;
"""
VIEW = {"lens": [[0, 0, 0]] * 6, "size": [1, 1], "section": None}


class Workbench:
    """A page with the shaders."""

    def __init__(self, browser: Any) -> None:
        self.context = browser.new_context()
        self.page = self.context.new_page()
        code = script() + PAGE % {"shaders": json.dumps(shaders()), "pieces": json.dumps(PIECES)}
        self.page.set_content("<canvas></canvas>")
        self.page.add_script_tag(content=code, type="module")
        self.page.wait_for_function("window.bench")
        self.loaded: Any = None
        self.edition = 0

    def load(self, world: Any) -> None:
        """Load a world's tables, unless they are loaded already."""
        if self.loaded is not world:
            self.page.evaluate("([data, origin]) => bench.load(data, origin)", [world.data, world.origin])
            self.loaded = world

    def run(self, glsl: str, inputs: Any, answers: int, sizes: Any = None, view: Any = None) -> Any:
        """Return the results of `glsl` for inputs (n, records, 4): float64 (n, answers)."""
        count, records, _ = inputs.shape
        fours = range(4)  # every WebGL 2 has so many targets, of four numbers
        assert answers <= 16, glsl
        targets = "\n".join(f"layout(location = {k}) out vec4 four_{k};" for k in fours)
        parts = (", ".join(f"answers[{4 * k + i}]" for i in range(4)) for k in fours)
        moves = " ".join(f"four_{k} = vec4({part});" for k, part in enumerate(parts))
        source = MAIN.replace("TARGETS", targets).replace("FOURS", moves).replace("CASE", glsl)
        text = base64.b64encode(np.ascontiguousarray(inputs, "<f4").tobytes()).decode()
        arguments = [
            f"case {self.edition} {glsl}",
            source,
            sizes or {},
            text,
            count,
            records,
            4 * len(fours),
            view or VIEW,
        ]
        found = self.page.evaluate("(arguments) => bench.run(...arguments)", arguments)
        pixels = np.frombuffer(base64.b64decode(found), "<f4").reshape(len(fours), -1, 4)
        return np.concatenate(pixels, axis=1)[:count, :answers].astype(float)

    def rewrite(self, piece: str, text: str) -> None:
        """Replace a piece of the shaders by another text."""
        self.edition += 1
        self.page.evaluate("([piece, text]) => { bench.graphics.sources.pieces[piece] = text; }", [piece, text])

    def close(self) -> None:
        self.context.close()
