// What the person has chosen. Everything else follows from it and from the scene.
import { copyOf, fitted } from "./camera.js";
import { add, minus, size, times } from "./vectors.js";

export const VIEWS = { front: [0, 1, 0], right: [-1, 0, 0], top: [0, 0.0005, -1], back: [0, -1, 0], left: [1, 0, 0], bottom: [0, 0.0005, 1] };

export function newState(scene) {
  return {
    camera: copyOf(scene.camera), hidden: new Set(), tints: new Map(), section: null, xray: false, measuring: false,
    measured: [], softness: 0, found: null, line: null, selected: -1, diagonal: diagonal(scene),
  };
}

export const diagonal = (scene) => Math.max(size(minus(scene.bounds[1], scene.bounds[0])), 1e-9);
export const middle = (scene) => times(add(scene.bounds[0], scene.bounds[1]), 0.5);

// What the film draws
export function viewOf(state) {
  return {
    camera: state.camera, section: state.section, xray: state.xray, chordScale: 2.5 / state.diagonal,
    softness: state.softness, depth: 10,
  };
}

export function namedView(state, scene, name, aspect) {
  return fitted(state.camera, scene.bounds, aspect, VIEWS[name]);
}

const number = (v) => String(Number(v.toPrecision(9)));
const list = (v) => `[${v.map(number).join(", ")}]`;

// The camera as a scene file has it
export function cameraYaml(camera) {
  const fields = `position: ${list(camera.position)}, look_at: ${list(camera.look_at)}, up: ${list(camera.up)}`;
  if (camera.height !== undefined) return `camera: {OrthographicCamera: {${fields}, height: ${number(camera.height)}}}`;
  return `camera: {${fields}, field_of_view: ${number(camera.field_of_view)}}`;
}

export const nameOf = (scene, item) => scene.items[item]?.name ?? `${scene.items[item]?.shape ?? "body"} ${item}`;
