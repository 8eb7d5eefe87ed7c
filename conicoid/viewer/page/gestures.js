// Mouse, touch and keys on the picture.
import { orbit, pan, zoom } from "./camera.js";

const CLICK = 5;        // pixels that a click may wander
const TURN = 0.0075;    // radians for a pixel
const STEP = 0.09;      // radians for a key

// act: { camera(), set(camera, moving), click(x, y), pivot(x, y) -> point, height(), key(name) }
export function listen(canvas, act) {
  const fingers = new Map();
  let start = null, wandered = 0, button = 0, pivot = null, lastWheel = 0;
  const place = (event) => { const r = canvas.getBoundingClientRect(); return [event.clientX - r.left, event.clientY - r.top]; };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { middle: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], gap: Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 };
  };

  canvas.addEventListener("pointerdown", (event) => {
    try { canvas.setPointerCapture(event.pointerId); } catch { /* a pointer that has already gone */ }
    canvas.focus({ preventScroll: true });
    fingers.set(event.pointerId, place(event));
    button = event.button || (event.shiftKey || event.ctrlKey || event.metaKey ? 2 : 0);
    if (fingers.size === 1) { start = place(event); wandered = 0; }
    else { wandered = Infinity; pivot = act.pivot(...spread().middle); }
  });
  canvas.addEventListener("pointermove", (event) => {
    const old = fingers.get(event.pointerId);
    if (!old) return;
    const now = place(event);
    if (fingers.size === 2) {
      const before = spread();
      fingers.set(event.pointerId, now);
      const after = spread();
      const shifted = pan(act.camera(), after.middle[0] - before.middle[0], after.middle[1] - before.middle[1], act.height());
      return act.set(zoom(shifted, before.gap / after.gap, pivot), true);
    }
    fingers.set(event.pointerId, now);
    wandered = Math.max(wandered, Math.hypot(now[0] - start[0], now[1] - start[1]));
    if (wandered < CLICK) return;
    const [dx, dy] = [now[0] - old[0], now[1] - old[1]];
    act.set(button ? pan(act.camera(), dx, dy, act.height()) : orbit(act.camera(), dx * TURN, dy * TURN), true);
  });
  const lift = (event) => {
    const now = fingers.get(event.pointerId);
    fingers.delete(event.pointerId);
    if (event.type === "pointerup" && now && wandered < CLICK && button === 0) act.click(...place(event));
    wandered = fingers.size ? Infinity : 0;
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    // The point under the pointer stays there; it is looked up once a gesture
    if (event.timeStamp - lastWheel > 300 || !pivot) pivot = act.pivot(...place(event));
    lastWheel = event.timeStamp;
    const amount = event.deltaMode === 1 ? event.deltaY * 18 : event.deltaY;
    act.set(zoom(act.camera(), Math.exp(Math.max(-150, Math.min(150, amount)) * 0.0022), pivot), true);
  }, { passive: false });

  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const camera = act.camera(), along = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
    if (along && event.shiftKey) act.set(pan(camera, -30 * along[0], -30 * along[1], act.height()), true);
    else if (along) act.set(orbit(camera, -along[0] * STEP, -along[1] * STEP), true);
    else if (event.key === "+" || event.key === "=") act.set(zoom(camera, 0.85, camera.look_at), true);
    else if (event.key === "-") act.set(zoom(camera, 1 / 0.85, camera.look_at), true);
    else if (!act.key(event.key.toLowerCase())) return;
    event.preventDefault();
  });
}
