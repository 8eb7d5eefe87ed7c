// The section plane: what is on its far side is cut away. A handle on the picture drags it along its normal.
import { basis, onScreen, pixelRay } from "./camera.js";
import { add, dot, minus, times } from "./vectors.js";
import { middle } from "./state.js";

const AXES = { x: [1, 0, 0], y: [0, -1, 0], z: [0, 0, 1] };

// The range of n·x over a box
export function reach(bounds, normal) {
  const ends = [0, 0];
  for (let k = 0; k < 3; k++) {
    const a = normal[k] * bounds[0][k], b = normal[k] * bounds[1][k];
    ends[0] += Math.min(a, b);
    ends[1] += Math.max(a, b);
  }
  return ends;
}

export function sectionAlong(state, scene, axis) {
  const old = state.section;
  if (axis === "flip" && old) return { normal: times(old.normal, -1), offset: -old.offset };
  const normal = axis === "view" ? times(basis(state.camera).forward, -1) : AXES[axis];
  return { normal, offset: dot(normal, middle(scene)) };
}

// Where the handle is: the point of the plane next to the middle of the scene
export function handlePoint(section, scene) {
  const center = middle(scene);
  return add(center, section.normal, section.offset - dot(section.normal, center));
}

// The plane moved so that its handle follows the pointer along the normal
export function dragged(section, scene, camera, x, y, width, height) {
  const from = handlePoint(section, scene), step = 1e-3 * Math.hypot(...minus(camera.position, from));
  const a = onScreen(camera, from, width, height), b = onScreen(camera, add(from, section.normal, step), width, height);
  const [low, high] = reach(scene.bounds, section.normal);
  let offset = section.offset;
  if (a && b && Math.hypot(b[0] - a[0], b[1] - a[1]) > 0.02) {
    // The point of the normal's line that is nearest to the pointer's ray
    const ray = pixelRay(camera, x, y, width, height), w = minus(from, ray.origin), along = dot(section.normal, ray.direction);
    offset += (along * dot(ray.direction, w) - dot(section.normal, w)) / (1 - along * along);
  } else {
    offset += ((a ? a[1] : y) - y) * step;
  }
  return { ...section, offset: Math.min(high, Math.max(low, offset)) };
}
