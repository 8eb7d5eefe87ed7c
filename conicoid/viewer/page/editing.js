// Sliders for the numbers of a body. The server lowers the scene again; the camera stays.
import { element } from "./panel.js";
import { nameOf } from "./state.js";

const steps = (low, high) => 10 ** Math.floor(Math.log10((high - low) / 200));

// change(path, value) asks for the new scene; one question at a time, the latest value wins
export function showSliders(root, scene, item, numbers, change) {
  const section = root.querySelector(".editing"), place = root.querySelector(".sliders");
  section.hidden = item < 0;
  if (item < 0) return;
  section.querySelector("h2").textContent = `Numbers of ${nameOf(scene, item)}`;
  place.replaceChildren();
  if (!numbers.length) place.append(element("p", { class: "how" }, "This body has no numbers of its own."));
  for (const { label, path, value, low, high } of numbers) {
    const step = String(steps(low, high));
    const range = element("input", { type: "range", min: String(low), max: String(high), step, value: String(value), "aria-label": label });
    const field = element("input", { type: "number", step: "any", value: String(value), "aria-label": `${label}, as a number` });
    range.addEventListener("input", () => { field.value = range.value; change(path, Number(range.value)); });
    field.addEventListener("change", () => { range.value = field.value; change(path, Number(field.value)); });
    place.append(element("div", { class: "number" }, element("span", { title: label }, label), range, field));
  }
}

// Calls of an asynchronous function, one at a time; those that a later one overtakes are left out. What comes back is
// kept when none is left: also by a call that had to wait
export function latest(call) {
  let running = null, next = null;
  const loop = async () => {
    try {
      while (next) {
        const values = next;
        next = null;
        await call(...values);
      }
    } finally { running = null; }
  };
  return (...values) => {
    next = values;
    return running ??= loop();
  };
}
