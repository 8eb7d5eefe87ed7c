// The camera: position, what it looks at, up; either a field of view in degrees or, without perspective, a height.
import { add, cross, minus, size, times, turned, unit } from "./vectors.js";

export const copyOf = (camera) => JSON.parse(JSON.stringify(camera));

export function basis(camera) {
  const forward = unit(minus(camera.look_at, camera.position));
  let right = cross(forward, unit(camera.up));
  if (size(right) < 1e-9) right = cross(forward, Math.abs(forward[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]);
  right = unit(right);
  return { forward, right, up: cross(right, forward) };
}

export const distance = (camera) => size(minus(camera.position, camera.look_at));

// o₀, o₁, o₂, d₀, d₁, d₂ of conicoid/render/camera.py
export function lens(camera) {
  const { forward, right, up } = basis(camera), zero = [0, 0, 0];
  if (camera.height !== undefined)
    return [camera.position, times(right, camera.height / 2), times(up, camera.height / 2), forward, zero, zero];
  const half = Math.tan((camera.field_of_view * Math.PI) / 360);
  return [camera.position, zero, zero, forward, times(right, half), times(up, half)];
}

// The ray of a pixel, counted from the top left corner: origin and unit direction
export function pixelRay(camera, x, y, width, height) {
  const rows = lens(camera), u = (2 * x - width) / height, v = (height - 2 * y) / height;
  return {
    origin: add(add(rows[0], rows[1], u), rows[2], v),
    direction: unit(add(add(rows[3], rows[4], u), rows[5], v)),
  };
}

// Where a point is seen, in pixels from the top left corner; null behind the camera
export function onScreen(camera, point, width, height) {
  const { forward, right, up } = basis(camera), to = minus(point, camera.position);
  const dot = (a) => a[0] * to[0] + a[1] * to[1] + a[2] * to[2];
  let u, v;
  if (camera.height !== undefined) [u, v] = [(2 * dot(right)) / camera.height, (2 * dot(up)) / camera.height];
  else {
    const depth = dot(forward) * Math.tan((camera.field_of_view * Math.PI) / 360);
    if (depth <= 0) return null;
    [u, v] = [dot(right) / depth, dot(up) / depth];
  }
  return [(u * height + width) / 2, (height - v * height) / 2];
}

// Turn about the point looked at; `up` stays, and the view never passes straight above or below
export function orbit(camera, across, upward) {
  const axis = unit(camera.up), away = minus(camera.position, camera.look_at), length = size(away);
  let turnedAway = turned(away, axis, -across);
  const side = unit(cross(axis, turnedAway));
  const angle = Math.acos(Math.max(-1, Math.min(1, (axis[0] * turnedAway[0] + axis[1] * turnedAway[1] + axis[2] * turnedAway[2]) / length)));
  const wanted = Math.max(0.01, Math.min(Math.PI - 0.01, angle - upward));
  turnedAway = turned(turnedAway, side, wanted - angle);
  return { ...camera, position: add(camera.look_at, turnedAway) };
}

// How long a pixel is at the distance of the point looked at
export function pixelSize(camera, height) {
  if (camera.height !== undefined) return camera.height / height;
  return (2 * distance(camera) * Math.tan((camera.field_of_view * Math.PI) / 360)) / height;
}

export function pan(camera, dx, dy, height) {
  const { right, up } = basis(camera), step = pixelSize(camera, height);
  const shift = add(times(right, -dx * step), up, dy * step);
  return { ...camera, position: add(camera.position, shift), look_at: add(camera.look_at, shift) };
}

// Nearer to a point by a factor < 1, which stays where it is on the screen
export function zoom(camera, factor, point) {
  const moved = (p) => add(point, minus(p, point), factor);
  const result = { ...camera, position: moved(camera.position), look_at: moved(camera.look_at) };
  if (camera.height !== undefined) result.height = camera.height * factor;
  return result;
}

// The whole box in view, from a direction
export function fitted(camera, bounds, aspect, towards) {
  const [low, high] = bounds, center = times(add(low, high), 0.5);
  const forward = unit(towards ?? minus(camera.look_at, camera.position));
  const seen = { ...camera, look_at: center, position: minus(center, forward) };
  if (towards) seen.up = [0, 0, 1];
  const { right, up } = basis(seen), half = Math.tan(((camera.field_of_view ?? 40) * Math.PI) / 360);
  let far = 0, tall = 0;
  for (let k = 0; k < 8; k++) {
    const corner = minus([0, 1, 2].map((i) => ((k >> i) & 1 ? high : low)[i]), center);
    const along = (a) => a[0] * corner[0] + a[1] * corner[1] + a[2] * corner[2];
    for (const [axis, slope] of [[right, half * aspect], [up, half]]) {
      far = Math.max(far, (1.08 * Math.abs(along(axis))) / slope - along(forward));
      tall = Math.max(tall, (2.16 * Math.abs(along(axis))) / (axis === right ? aspect : 1));
    }
  }
  seen.position = add(center, forward, -Math.max(far, 1e-9));
  if (camera.height !== undefined) seen.height = tall;
  return seen;
}
