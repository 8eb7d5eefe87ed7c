// What the exact engine in the page says about a ray: the answer of conicoid/viewer/scene_data.py, to the bit.
import { Engine, bitsOf, inflated, ofBits, whole } from "./engine.js";
import { decoded } from "./tables.js";
import { add, dot } from "./vectors.js";

const DOUBTFUL = 16;     // a turn above it is of a hit that rounding might have changed
const SPAN = 9, CROSSING = 7;  // columns
const SHEET = 3;         // kinds of entry from there on are sheets
const MUCH = 2 ** -24;   // of |t| and of |o| / |d|: a larger bound is replaced by an exact one, which takes the desktop
const SMALLEST = 1e-100, BELOW_ROUNDING = 2 ** -60;
const OPEN = "Floating point cannot decide this ray: it takes the exact arithmetic of Conicoid's desktop engine.";
const REASONS = [null, "the origin is not finite", "the direction is not finite", "the direction is zero", "the origin is too large or too small", "the direction is too large or too small"];

// The next float after x, up or down
export function next(x, up) {
  if (!Number.isFinite(x)) return x;
  if (x === 0) return up ? Number.MIN_VALUE : -Number.MIN_VALUE;
  return ofBits(bitsOf(x) + (up === x > 0 ? 1n : -1n));
}

// Components that are neither of the domain nor of weight are 0
export function withoutTraces(vector) {
  const largest = Math.max(...vector.map(Math.abs));
  return vector.map((v) => (Math.abs(v) < SMALLEST && Math.abs(v) <= BELOW_ROUNDING * largest ? 0 : v));
}

const finite = (t) => (Number.isFinite(t) ? t : null);

export class Exact {
  // `data`: of the page; `scene`: as `decodedScene` makes it
  static async open(data, scene) {
    try {
      const [code, content, names] = await Promise.all([data.code, data.content, data.names].map(inflated));
      return new Exact(await Engine.open(code), data, scene, content, JSON.parse(new TextDecoder().decode(names)));
    } catch (error) { throw new Error(`The engine in this page does not run here (${error.message}).`); }
  }

  // `names`: of all bodies, of which the page's list has the first only
  constructor(engine, data, scene, content, names) {
    this.engine = engine;
    this.names = names;
    this.scene = scene;
    const views = { f8: Float64Array, i8: BigInt64Array, i4: Int32Array }, tables = { ...scene.t };
    let at = 0;
    for (const [name, kind, count] of data.parts) {
      const bytes = views[kind].BYTES_PER_ELEMENT * count;
      tables[name] = new views[kind](content.slice(at, at + bytes));
      at += bytes;
    }
    const array = (kind, shape, values) => engine.array(kind, shape, values);
    const places = array("i8", [tables.places.length], tables.places);
    const integers = array("i4", [data.lengths[0]]), floats = array("f8", [data.lengths[1]]);
    data.order.forEach((name, k) => {
      const table = tables[name];
      engine.view(table instanceof Float64Array ? floats : integers).set(table, Number(tables.places[k]));
    });
    this.geometry = [places, integers, floats];
    this.rest = ["planes", "spheres", "quadrics", "vertices"].map((name) => array("f8", [tables[`rest_${name}`].length], tables[`rest_${name}`]));
    const i4 = (n) => array("i4", [n]), f8 = (n) => array("f8", [n]);
    this.settling = [this.rest, [places, integers, f8(data.canonical)], data.ranks.map(([kind, count]) => array(kind, [count]))];
    this.line = [f8(3), f8(3)].map((each) => ({ ...each, shape: [1, 3] }));
    this.limits = [f8(1), f8(1)];
    this.starts = array("i4", [1], [-1]);
    this.found = Object.fromEntries(data.hit.map(([name, kind]) => [name, array(kind, [1])]));
    this.faces = array("i4", [3, 1]);
    this.point = array("f8", [1, 3]);
    this.far = array("i1", [1]);
    this.normal = array("f8", [1, 3]);
    this.uv = array("f8", [1, 2]);
    this.counts = i4(1);
    this.doubts = array("i1", [1]);
    this.doubtful = [array("i4", [1], [0]), array("i1", [1])];
    this.sheets = new Set([...tables.entry_kind.keys()].filter((k) => tables.entry_kind[k] >= SHEET));
    this.one = { which: array("i8", [0]), t: f8(1), surface: i4(1), errors: f8(1) };
  }

  get rays() { return [...this.line, ...this.limits, this.starts]; }

  read(array) { return Array.from(this.engine.view(array)); }

  // Take a ray; throws where it cannot be traced
  take({ origin, direction }) {
    [origin, direction].forEach((vector, k) => this.engine.view(this.line[k]).set(vector));
    const reason = Number(this.engine.call("first_invalid", ...this.line).getBigInt64(8, true));
    if (reason) throw new Error(`This ray cannot be traced: ${REASONS[reason]}.`);
  }

  between(low, high) { [low, high].forEach((t, k) => { this.engine.view(this.limits[k])[0] = t; }); }

  // The first hit of the ray within limits: `Hits` of the desktop
  firstHit(low, high) {
    const { engine, geometry, found } = this, all = Object.values(found), one = [0n, 1n];
    this.between(low, high);
    engine.call("trace_first_alone", geometry, this.rays, ...one, all);
    if (engine.view(found.turn)[0] > DOUBTFUL && !this.settle("settle_first", ...one, all)) throw new Error(OPEN);
    engine.call("faces_of", geometry, found.entry, found.place, found.turn, ...one, this.faces);
    const [surface, face] = this.read(this.faces), [t] = this.read(found.t), [body] = this.read(found.body);
    const entering = Math.abs(this.read(found.turn)[0]) === 2;
    return { t, body, surface, face, entering, t_error: this.errorOf(t, surface), ...this.place() };
  }

  // Point, normal and uv of what is in `found` and `faces`
  place() {
    const { engine, geometry, found } = this, one = [0n, 1n];
    engine.call("hit_points", ...this.line, found.t, ...one, this.point, this.far);
    engine.call("normals_of", geometry, this.faces, this.point, ...one, this.normal);
    engine.call("uvs_of", geometry, found.body, this.faces, this.point, ...one, this.uv);
    return { point: this.read(this.point), normal: withoutTraces(this.read(this.normal)), uv: this.read(this.uv) };
  }

  // Decide a ray in doubt with numbers of 30 digits; false where these leave it open
  settle(kernel, ...rest) {
    this.engine.view(this.doubtful[1])[0] = 0;
    this.engine.call(kernel, this.geometry, this.settling, this.rays, this.doubtful, ...rest);
    return this.engine.view(this.doubtful[1])[0] !== 1;
  }

  // Spans or crossings of the ray within limits, as rows
  rows(spans, low, high) {
    const { engine, geometry, counts, doubts } = this, columns = spans ? SPAN : CROSSING;
    this.between(low, high);
    engine.call("trace_rows_alone", geometry, this.rays, spans, 0n, 1n, counts, doubts);
    const found = engine.rows(columns);
    if (engine.view(doubts)[0] === 0) return found;
    const settled = this.settle("settle_rows", spans, counts), rows = engine.rows(columns);
    if (!settled) throw new Error(OPEN);
    return rows;
  }

  // A bound on the error of t; null where there is none, or only one by exact arithmetic
  errorOf(t, surface) {
    if (surface < 0) return 0;
    const { engine, one } = this;
    engine.view(one.t)[0] = t;
    engine.view(one.surface)[0] = surface;
    engine.call("errors_of_t", this.geometry, this.rest, ...this.line, one.which, one.t, one.surface, 0n, 1n, one.errors);
    const [error] = this.read(one.errors), [o, d] = this.line.map((each) => Math.max(...this.read(each).map(Math.abs)));
    return error <= MUCH * Math.abs(t) || error <= MUCH * (Math.abs(t) + o / d) ? error : null;
  }

  // As `pick` of conicoid/viewer/scene_data.py
  pick(ray, { hidden, section }) {
    this.take(ray);
    const kept = interval(section, ray), crossings = this.crossings(hidden, kept), [spans, all] = this.spans(hidden, kept);
    const cuts = all.filter((cut) => !crossings.length || cut.t <= crossings[0].t), rest = { spans, crossings };
    if (cuts.length) return { found: { ...cutBy(cuts[0], section, ray), ...rest } };
    if (!crossings.length) return { found: null };
    const chosen = hidden.size > 0 || section !== null;
    return { found: { ...this.hit(crossings[0], chosen), ...rest } };
  }

  named(body) { return { body, name: this.names[this.scene.body_item[body]] }; }

  crossings(hidden, [low, high]) {
    const rows = this.rows(false, 0, Infinity), { scene } = this, shown = [];
    this.side = null;
    for (const [t, body, face, surface, side, enters] of rows) {
      if (hidden.has(scene.body_item[body]) || !(this.sheets.has(body) || (low < t && t < high))) continue;
      shown.push({ t, face, surface, entering: enters !== 0, t_error: finite(this.errorOf(t, surface)), ...this.named(body) });
      this.side ??= side;
    }
    return shown;
  }

  // Spans, and the ends that the section plane makes, in order
  spans(hidden, kept) {
    const low = Math.max(0, kept[0]), high = kept[1], spans = [], cuts = [];
    if (!(low < high)) return [spans, cuts];
    for (const [enter, body, exit, starts, ends] of this.rows(true, low, high)) {
      if (hidden.has(this.scene.body_item[body])) continue;
      const named = this.named(body);
      spans.push({ ...named, enter: finite(enter), exit: finite(exit) });
      if (starts !== 0 && enter === kept[0] && enter > 0) cuts.push({ t: enter, entering: true, ...named });
      if (ends !== 0 && exit === kept[1]) cuts.push({ t: exit, entering: false, ...named });
    }
    return [spans, cuts.filter((cut) => Number.isFinite(cut.t)).sort((a, b) => a.t - b.t)];
  }

  // The first hit; `chosen`: of what is shown, which is a crossing known already
  hit(first, chosen) {
    const limits = chosen ? [next(first.t, false), next(first.t, true)] : [0, Infinity];
    let { body, point, normal, uv } = this.firstHit(...limits);
    if (body !== first.body) {  // the wall is a hidden body's too, which is listed earlier
      const { engine, found } = this;
      engine.view(found.t)[0] = first.t;
      engine.view(found.body)[0] = first.body;
      engine.view(this.faces).set([first.surface, first.face, this.side]);
      ({ point, normal, uv } = this.place());
    }
    return { ...first, point, normal, uv };
  }
}

// Where a ray is in the half-space that is kept
function interval(section, { origin, direction }) {
  if (!section) return [-Infinity, Infinity];
  const height = dot(section.normal, origin) - section.offset, rate = dot(section.normal, direction);
  if (rate === 0) return height <= 0 ? [-Infinity, Infinity] : [Infinity, -Infinity];
  return rate < 0 ? [-height / rate, Infinity] : [-Infinity, -height / rate];
}

function cutBy(cut, section, { origin, direction }) {
  const { normal } = section, length = Math.sqrt(dot(normal, normal));
  return { ...cut, face: null, surface: null, point: add(origin, direction, cut.t), normal: normal.map((v) => v / length), uv: null };
}
