// A ray in numbers: of the last click, to be copied, or typed, to be asked.

// Three numbers in a text such as "0, 0, 5" or "[0, 0, 5]"; an error that says what is expected
export function threeNumbers(name, text) {
  const words = text.replace(/[[\](),;]/g, " ").trim().split(/\s+/), found = words.map(Number);
  if (found.length !== 3 || words.includes("") || !found.every(Number.isFinite)) throw new Error(`${name}: three numbers, such as 0, 0, 5`);
  return found;
}

const fields = (root) => ["origin", "direction"].map((name) => root.querySelector(`[name=${name}]`));

export function showRay(root, { origin, direction }) {
  fields(root).forEach((field, k) => { field.value = [origin, direction][k].join(", "); });
}

export function typedRay(root) {
  const [origin, direction] = fields(root).map((field) => threeNumbers(field.labels[0].textContent.trim(), field.value));
  return { origin, direction };
}

// Enter asks as the button does; no form, which a frame may be forbidden to send
export function listenForRays(root, ask) {
  for (const field of fields(root)) field.addEventListener("keydown", (event) => { if (event.key === "Enter") ask(); });
}
