// What was found at a point: the answer of the exact engine, or the shader's, and which of them it is.
import { distanceBetween } from "./measure.js";
import { element } from "./panel.js";

const EXACT = {
  engine: "Computed by the exact engine.",
  page: "Exact: computed in this page, to the same bits as by Conicoid's engine.",
  python: "Exact: computed by Conicoid itself, which runs in this page.",
};
const exactText = (v) => (v === null ? "none" : String(v));
const shortText = (v) => (v === null ? "none" : String(Number(v.toPrecision(6))));

// What is known of the error of the distance; of a cut by the section plane nothing is asked
function errorOf(found) {
  if (typeof found.t_error === "number") return [["Its error", `at most ${exactText(found.t_error)}`]];
  return found.t_error === null && found.by === "page" ? [["Its error", "left open: its bound takes exact arithmetic"]] : [];
}

// A second line in a row, where more is known: of a crossing its bound and normal, of a span the bounds of its ends
const moreOf = (c) => c.normal && `t ${atMost(c.t_error)}; normal ${c.normal.map(exactText).join("  ")}`;
const moreOfSpan = (s) => s.enter_error !== undefined && `from ${atMost(s.enter_error)}, to ${atMost(s.exit_error)}`;

// A bound in two digits, rounded up
export function atMost(v) {
  if (v === null) return "without a bound";
  const text = v.toExponential(1), unit = Number(`1e${Number(text.split("e")[1]) - 1}`);
  return v === 0 ? "exact" : `± ${Number(text) < v ? (v + unit).toExponential(1) : text}`;
}

function withMore(list, rows, more) {
  const lines = [...list.querySelectorAll("tr")].slice(1);
  rows.forEach((row, k) => {
    const text = more(row);
    if (text) lines[k].after(element("tr", { class: "more" }, element("td", { colspan: String(lines[k].children.length) }, text)));
  });
  return list;
}

function table(rows, head) {
  const body = rows.map((cells) => element("tr", {}, ...cells.map((text, k) => element(!head && k === 0 ? "th" : "td", {}, text))));
  const heading = head ? [element("tr", {}, ...head.map((text) => element("th", { scope: "col" }, text)))] : [];
  return element("table", {}, ...heading, ...body);
}

// The working of the ray, asked for when it is opened
function reasons(why) {
  const text = element("pre", { class: "why", tabindex: "0" }, "…");
  const box = element("details", { class: "reasons" }, element("summary", {}, "Why"), text);
  box.addEventListener("toggle", async () => { text.textContent = await why(); }, { once: true });
  return box;
}

export function showDetails(root, state) {
  const section = root.querySelector(".found"), place = root.querySelector(".details");
  section.hidden = !state.found && !state.measured.length;
  // What stands there already keeps its focus and what is open
  if (place.found === state.found && place.measured === state.measured) return;
  Object.assign(place, { found: state.found, measured: state.measured });
  place.replaceChildren();
  if (state.measured.length) {
    const text = state.measured.length < 2 ? "Click a second point." : `Distance ${distanceBetween(state.measured).toPrecision(7)}`;
    place.append(element("p", { class: "distance" }, text));
  }
  const found = state.found;
  if (!found) return;
  const exact = found.by !== "shader", text = exact ? exactText : shortText, row = (v) => v.map(text).join("  ");
  const how = exact ? EXACT[found.by] : `Computed by the shader, in single precision. ${found.note ?? ""}`;
  place.append(element("p", { class: "how" }, how.trim()));
  const rows = [["Body", found.name], ["Face", found.face === null ? "section plane" : String(found.face)], ["Distance", text(found.t)],
    ...errorOf(found),
    ["Point", row(found.point)], ["Normal", row(found.normal)], ["uv", found.uv ? row(found.uv) : "none"], ["Side", found.entering ? "entered here" : "left here"]];
  const first = table(rows);
  first.className = "hit";
  place.append(first);
  if (found.why) place.append(reasons(found.why));
  if (found.spans) {
    const inside = found.spans.map((s) => [s.name, text(s.enter), text(s.exit)]);
    const list = withMore(table(inside, ["Inside", "from", "to"]), found.spans, moreOfSpan);
    list.className = "spans";
    place.append(element("details", { open: true }, element("summary", {}, `Spans along the ray (${inside.length})`), element("div", { class: "rows", tabindex: "0" }, list)));
  }
  const crossings = found.crossings.map((c) => [c.name, String(c.face ?? "cut"), text(c.t), c.entering ? "in" : "out"]);
  const list = withMore(table(crossings, ["Body", "Face", "t", ""]), found.crossings, moreOf);
  list.className = "crossings";
  place.append(element("details", { open: found.crossings.some(moreOf) }, element("summary", {}, `Entries and exits (${crossings.length})`), element("div", { class: "rows", tabindex: "0" }, list)));
}
