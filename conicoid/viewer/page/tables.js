// The lowered tables of the engine, packed into records of four for two textures. Places are made relative to an
// origin near the camera, in double precision, before they are rounded to single.
import { dot } from "./vectors.js";

const FAR = 1e30;
export const PLANE = 0, SPHERE = 1, QUADRIC = 2;
export const OPAQUE = 1, MEDIUM = 2, HIDDEN = 4, TINTED = 8;

export function decoded(item) {
  const text = atob(item.f8 ?? item.i4);
  const bytes = Uint8Array.from(text, (c) => c.charCodeAt(0));
  return item.f8 !== undefined ? new Float64Array(bytes.buffer) : new Int32Array(bytes.buffer);
}

export function decodedScene(data) {
  const t = Object.fromEntries(Object.entries(data.tables).map(([name, item]) => [name, decoded(item)]));
  const look = { ...data.look };
  for (const name of ["materials", "row_of", "face_row", "opaque", "medium"]) look[name] = decoded(data.look[name]);
  return { ...data, t, look, body_item: decoded(data.body_item) };
}

class Records {
  constructor() { this.rows = []; }
  get next() { return this.rows.length / 4; }
  put(a = 0, b = 0, c = 0, d = 0) { this.rows.push(a, b, c, d); }
}

// Where each surface's floats begin, and the records of integers; they do not depend on the origin
export function packedIntegers(scene, styles) {
  const t = scene.t, maps = t.face_maps, ints = new Records(), place = [];
  const table = (fill) => { place.push(ints.next); fill(); };
  const planes = 2, quadrics = 5, counts = [t.planes.length / 7, t.spheres.length / 4, t.quadrics.length / 4];
  const start = [0, planes * counts[0], planes * counts[0] + counts[1]];
  const width = [planes, 1, quadrics];
  const floats = { uv: start[2] + quadrics * counts[2] };
  floats.boxes = floats.uv + 4 * (maps.length / 3);
  floats.vertices = floats.boxes + 12 * (t.node_boxes.length / 48);
  floats.materials = floats.vertices + t.vertices.length / 3;
  floats.frames = floats.materials + scene.look.materials.length / 4;
  floats.lights = floats.frames + t.ball_frames.length / 3;
  floats.end = floats.lights + 4 * scene.lights.length;

  table(() => t.surface_kind.forEach((kind, i) => ints.put(kind, start[kind] + width[kind] * t.surface_row[i])));
  table(() => t.cell_quadric.forEach((quadric, i) =>
    ints.put(quadric, 2 * (Math.abs(t.cell_face[i]) - 1) + (t.cell_face[i] > 0 ? 1 : 0), t.cell_first[i], t.cell_first[i + 1])));
  table(() => t.plane_surface.forEach((surface, i) => ints.put(surface, Math.sign(t.plane_face[i]), Math.abs(t.plane_face[i]) - 1)));
  table(() => t.leaf_cell.forEach((cell, i) => ints.put(cell, t.leaf_gate[i], t.leaf_negated[i], t.leaf_sense[i])));
  table(() => t.gate_parent.forEach((parent, i) => ints.put(parent, t.gate_need[i], t.gate_negated[i], t.gate_start[i])));
  table(() => {
    for (let i = 0; i + 1 < t.program_leaf.length; i++)
      ints.put(t.program_leaf[i], t.program_gate[i], t.program_gate[i + 1]);
  });
  table(() => t.sheet_surface.forEach((surface, i) =>
    ints.put(surface, t.sheet_program[i], t.sheet_side[i], t.sheet_one_sided[i])));
  table(() => t.polygon_surface.forEach((surface, i) =>
    ints.put(2 * surface + (t.polygon_side[i] > 0 ? 1 : 0), t.polygon_program[i], t.polygon_first[i], t.polygon_first[i + 1])));
  table(() => t.entry_kind.forEach((kind, i) => ints.put(kind, t.entry_index[i], i)));
  table(() => t.body_face.forEach((face, i) => {
    const item = scene.body_item[i], tint = styles.tints.get(item);
    const flags = (scene.look.opaque[i] ? OPAQUE : 0) | (scene.look.medium[i] ? MEDIUM : 0)
      | (styles.hidden.has(item) ? HIDDEN : 0) | (tint !== undefined ? TINTED : 0);
    ints.put(face, scene.look.row_of[i], flags, tint ?? 0);
  }));
  table(() => {
    for (let i = 0; i < maps.length / 3; i++) ints.put(scene.look.face_row[i] ?? -1, floats.uv + 4 * i);
  });
  table(() => { for (let i = 0; i < t.node_children.length; i += 4) ints.put(...t.node_children.subarray(i, i + 4)); });
  table(() => t.tree_order.forEach((item) => ints.put(item)));
  table(() => { for (let i = 0; i + 1 < t.tree_root.length; i++) ints.put(t.tree_root[i], t.tree_root[i + 1]); });
  floats.rootList = ints.next;
  t.roots.forEach((code) => ints.put(code));
  floats.tree = t.tree_root.length - 2;
  return { records: Int32Array.from(ints.rows), place, floats };
}

// All floats, relative to an origin
export function packedFloats(scene, floats, origin) {
  const t = scene.t, maps = t.face_maps, out = new Float32Array(4 * floats.end);
  let at = 0;
  const put = (...values) => { for (const v of values) out[at++] = Math.min(FAR, Math.max(-FAR, v)); };
  for (let i = 0; i < t.planes.length; i += 7) {
    // The foot of the perpendicular from the origin is the anchor
    const [n0, n1, n2, over, a0, a1, a2] = t.planes.subarray(i, i + 7), n = [n0, n1, n2];
    const square = dot(n, n), height = dot(n, [origin[0] - a0, origin[1] - a1, origin[2] - a2]) + over, s = -height / square;
    put(n0, n1, n2, 0, s * n0, s * n1, s * n2, 0);
  }
  for (let i = 0; i < t.spheres.length; i += 4)
    put(t.spheres[i] - origin[0], t.spheres[i + 1] - origin[1], t.spheres[i + 2] - origin[2], t.spheres[i + 3]);
  for (let i = 0; i < t.quadrics.length; i += 4) {
    const form = 16 * t.quadrics[i + 3];
    put(t.quadrics[i] - origin[0], t.quadrics[i + 1] - origin[1], t.quadrics[i + 2] - origin[2]);
    put(...t.quadric_forms.subarray(form, form + 16), 0);
  }
  for (let i = 0; i < maps.length; i += 3) {
    const angular = maps[i] < 0;
    for (let k = 0; k < 3; k++) {
      const at = 4 * (angular && k === 0 ? -1 - maps[i] : maps[i + k]), row = t.map_rows.subarray(at, at + 4);
      put(row[0], row[1], row[2], dot(row, origin) + row[3]);
    }
    put(angular ? 1 : 0, 0, 0, 0);
  }
  // Boxes are widened by what single precision may lose
  for (let i = 0; i < t.node_boxes.length; i += 48)
    for (let k = 0; k < 48; k++) {
      const axis = (k >> 3) % 3, v = t.node_boxes[i + k], high = k >= 24;
      const margin = 4e-6 * (Math.abs(v - origin[axis]) + t.extent[0]);
      put(Number.isFinite(v) ? v - origin[axis] + (high ? margin : -margin) : v);
    }
  for (let i = 0; i < t.vertices.length; i += 3)
    put(t.vertices[i] - origin[0], t.vertices[i + 1] - origin[1], t.vertices[i + 2] - origin[2], 0);
  const m = scene.look.materials;
  for (let i = 0; i < m.length; i += 32) {
    put(...m.subarray(i, i + 28));
    // A pattern in space begins where the origin lies in it
    for (let k = 0; k < 3; k++) { const cells = origin[k] / (m[i + 8 + k] || 1); put(cells - 2 * Math.floor(cells / 2)); }
    put(m[i + 31]);
  }
  for (let i = 0; i < t.ball_frames.length; i += 3) put(t.ball_frames[i], t.ball_frames[i + 1], t.ball_frames[i + 2], 0);
  for (const light of scene.lights) {
    put(...light.position.map((v, k) => v - origin[k]), light.parallel, ...light.axis, light.fades);
    put(...light.intensity, light.outer ?? FAR, light.inner ?? FAR, light.radius, 0, 0);
  }
  return out;
}

// Sizes of the shader's arrays and what it needs to know at compile time
export function shaderSizes(scene) {
  const t = scene.t;
  let gates = 1, leaves = 1;
  for (let i = 0; i + 1 < t.program_gate.length; i++) {
    gates = Math.max(gates, t.program_gate[i + 1] - t.program_gate[i]);
    leaves = Math.max(leaves, t.program_leaf[i + 1] - t.program_leaf[i]);
  }
  const m = scene.look.materials;
  let bounces = false;
  for (let i = 0; i < m.length; i += 32) bounces ||= [16, 17, 18, 20, 21, 22].some((k) => m[i + k] > 0) || m[i + 23] > 0;
  const power = (n) => 2 ** Math.ceil(Math.log2(n));
  return {
    STACK: power(2 * t.tree_depth[0]),
    GATES: power(gates),
    EVENTS: Math.min(32, power(4 * leaves)),
    RAYS: bounces ? 14 : 2,
    STEPS: bounces ? 4096 : 64 + scene.lights.length,
    ANY_TRANSPARENT: scene.look.any_transparent ? 1 : 0,
    ANY_PROGRAM: t.program_leaf.length > 1 ? 1 : 0,
  };
}
