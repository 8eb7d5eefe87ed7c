// The panel: bodies, section, look. It only reads and sets what the person has chosen.
import { nameOf } from "./state.js";

export function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in node && typeof value !== "string") node[key] = value;
    else node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

const hex = (rgb) => "#" + rgb.toString(16).padStart(6, "0");

// The material's colour as sRGB, for the colour field
export function itemColor(scene, item) {
  const body = scene.body_item.indexOf(item), m = scene.look.materials, at = 32 * (scene.look.row_of[body] ?? 0);
  let rgb = 0;
  for (let k = 0; k < 3; k++) {
    const c = Math.max(0, Math.min(1, m[at + k])), s = c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
    rgb = rgb * 256 + Math.round(255 * s);
  }
  return rgb;
}

// Fill a list anew; what had the focus has it again, and it stays where it was scrolled to
function refilled(list, fill) {
  const focused = list.getRootNode().activeElement, row = list.contains(focused) ? focused.closest("[data-item]") : null;
  const controls = (of) => [...(of?.querySelectorAll("input, button") ?? [])];
  const index = controls(row).indexOf(focused), top = list.scrollTop;
  list.replaceChildren();
  fill();
  list.scrollTop = top;
  if (row) controls(list.querySelector(`[data-item="${row.dataset.item}"]`))[index]?.focus({ preventScroll: true });
}

// act: { restyle(), select(item) }
export function listBodies(list, scene, state, act) {
  refilled(list, () => fillBodies(list, scene, state, act));
}

function fillBodies(list, scene, state, act) {
  scene.items.forEach((item, i) => {
    const name = nameOf(scene, i), shown = !state.hidden.has(i);
    const box = element("input", { type: "checkbox", checked: shown, "aria-label": `Show ${name}` });
    box.addEventListener("change", () => { state.hidden[box.checked ? "delete" : "add"](i); act.restyle(); });
    const others = scene.items.length - 1, alone = shown && others > 0 && state.hidden.size === scene.item_count - 1;
    const only = element("button", { "aria-pressed": String(alone), title: `Show only ${name}` }, "Only");
    only.addEventListener("click", () => {
      state.hidden = new Set(alone ? [] : Array.from({ length: scene.item_count }, (_, k) => k).filter((k) => k !== i));
      act.restyle();
    });
    const color = element("input", { type: "color", value: hex(state.tints.get(i) ?? itemColor(scene, i)), "aria-label": `Colour of ${name}`, title: "Tint" });
    color.addEventListener("input", () => { state.tints.set(i, parseInt(color.value.slice(1), 16)); act.restyle(true); });
    const row = element("li", { "data-item": String(i) }, color,
      element("label", {}, box, element("span", { class: shown ? "name" : "name gone", title: `${name}: ${item.shape}` }, name)));
    if (act.edits) {
      const edit = element("button", { "aria-pressed": String(state.selected === i), title: `Change the numbers of ${name}` }, "Edit");
      edit.addEventListener("click", () => act.select(state.selected === i ? -1 : i));
      row.append(edit);
    }
    row.append(only);
    list.append(row);
  });
  if (scene.item_count > scene.items.length)
    list.append(element("li", {}, `and ${scene.item_count - scene.items.length} more`));
}

export function showSection(root, state, place) {
  root.querySelector("[name=section]").checked = Boolean(state.section);
  root.querySelector(".cutting").hidden = !state.section;
  if (state.section) root.querySelector("[name=place]").value = place;
  for (const button of root.querySelectorAll("[data-axis]")) {
    const axis = "xyz".indexOf(button.dataset.axis), n = state.section?.normal;
    if (axis >= 0) button.setAttribute("aria-pressed", String(Boolean(n) && Math.abs(n[axis]) > 0.999));
  }
}
