// Marks over the picture: the point asked about, and the distance between two.
import { onScreen } from "./camera.js";
import { add, minus, size } from "./vectors.js";

const SVG = "http://www.w3.org/2000/svg";

function shape(parent, name, attributes, text) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
}

function drawCross(svg, [x, y]) {
  for (const kind of ["halo", "mark"]) shape(svg, "path", { class: kind, d: `M${x - 7} ${y}h14M${x} ${y - 7}v14` });
}

export const distanceBetween = (points) => size(minus(points[1], points[0]));

// A ray that was given in numbers: thin from its origin on, thick within bodies
function drawRay(svg, { origin, direction }, { t, spans, crossings }, seen) {
  const end = Math.max(t, ...(spans ?? []).map((span) => span.exit ?? 0), ...crossings.map((each) => each.t));
  const line = (from, to, kinds) => {
    const [a, b] = [from, to].map((at) => seen(add(origin, direction, at)));
    if (a && b) for (const kind of kinds) shape(svg, "path", { class: kind, d: `M${a[0]} ${a[1]}L${b[0]} ${b[1]}` });
  };
  line(0, 1.25 * end, ["halo thin", "mark thin"]);
  for (const { enter, exit } of spans ?? []) line(enter ?? 0, exit ?? 1.25 * end, ["halo", "mark within"]);
}

export function drawMarks(svg, state, width, height) {
  svg.replaceChildren();
  const seen = (point) => onScreen(state.camera, point, width, height);
  if (state.found && state.line) drawRay(svg, state.line, state.found, seen);
  if (state.found && !state.measuring) { const at = seen(state.found.point); if (at) drawCross(svg, at); }
  const ends = state.measured.map(seen);
  ends.filter(Boolean).forEach((at) => drawCross(svg, at));
  if (ends.length < 2 || !ends[0] || !ends[1]) return;
  const [[x1, y1], [x2, y2]] = ends;
  for (const kind of ["halo", "mark"]) shape(svg, "path", { class: kind, d: `M${x1} ${y1}L${x2} ${y2}` });
  shape(svg, "text", { x: (x1 + x2) / 2 + 8, y: (y1 + y2) / 2 - 8, class: "length" }, distanceBetween(state.measured).toPrecision(7));
}
