// The page put together.
import { listenForRays, showRay, typedRay } from "./asking.js";
import { copyOf, fitted, onScreen, pixelRay } from "./camera.js";
import { showDetails } from "./details.js";
import { latest, showSliders } from "./editing.js";
import { Exact } from "./exact.js";
import { Film } from "./film.js";
import { listen } from "./gestures.js";
import { GAVE_UP, Graphics } from "./graphics.js";
import { Server } from "./live.js";
import { drawMarks } from "./measure.js";
import { listBodies, showSection } from "./panel.js";
import { Picker } from "./pick.js";
import { dragged, handlePoint, reach, sectionAlong } from "./section.js";
import { VIEWS, cameraYaml, nameOf, namedView, newState, viewOf } from "./state.js";
import { decodedScene } from "./tables.js";
import { add, dot, minus, size } from "./vectors.js";
import { Waiting } from "./waiting.js";

const SILENT = "No kernel has answered: it is busy, or there is none.";
const REACH = 64;  // the camera may be so many times further from the origin than from what it looks at

export class Viewer {
  // `kernel`: of a notebook, where one may answer; `server`: of a page that is more than a scene's
  constructor(root, data, kernel = null, server = null) {
    this.root = root;
    this.find = (selector) => root.querySelector(selector);
    this.canvas = this.find("canvas");
    this.title = data.title;
    this.carried = data.engine ?? null;
    this.waiting = new Waiting(root, data.preview);
    this.graphics = new Graphics(this.canvas, data.shaders);
    this.picker = new Picker(this.graphics);
    this.film = new Film(this.graphics, () => viewOf(this.state), {
      may: () => this.waiting.seen(), first: () => this.waiting.end(), failed: (error) => this.failed(error),
    });
    this.server = server ?? (data.served ? new Server(data.served) : null);
    this.kernel = kernel;
    this.accept(data.scene);
    this.wire();
    if (this.server) this.server.watch((answer) => this.answered(answer), (lost) => this.lost(lost));
    if (data.served?.select !== undefined) this.select(data.served.select);
  }

  // Take a scene; the camera and what has been chosen stay where that makes sense
  accept(data, keep = false) {
    const old = this.state, scene = decodedScene(data);
    const state = newState(scene);
    if (keep && old) {
      const within = (k) => k < scene.item_count;
      Object.assign(state, { camera: old.camera, xray: old.xray, softness: old.softness, section: old.section, measuring: old.measuring });
      state.hidden = new Set([...old.hidden].filter(within));
      state.tints = new Map([...old.tints].filter(([k]) => within(k)));
      state.selected = within(old.selected) ? old.selected : -1;
    }
    this.graphics.load(scene, state, [...state.camera.look_at]);
    this.scene = scene;
    this.state = state;
    this.find("h1").textContent = this.title;
    const count = (n, what) => `${n.toLocaleString("en")} ${n === 1 ? what : what === "body" ? "bodies" : what + "s"}`;
    this.find(".facts").textContent = `${count(scene.body_item.length, "body")}, ${count(scene.t.surface_kind.length, "surface")}, ${count(scene.lights.length, "light")}`;
    this.trouble(null);
    this.changed();
  }

  // What cannot be drawn: said over the last picture, or in place of the first
  failed(error) {
    if (this.waiting.over) return this.trouble("This scene cannot be drawn.", error.message);
    this.end();
    showInstead(this.root, error.message, this.waiting.source);
  }

  answered({ scene, trouble }) {
    if (this.ended) return;
    if (trouble) return this.trouble("The scene file has mistakes; the last good scene is shown.", trouble);
    try { this.accept(scene, true); } catch (error) { this.trouble("This scene cannot be drawn.", error.message); }
    if (this.state.selected >= 0) this.select(this.state.selected);
  }

  lost(lost) {
    if (this.ended) return;
    if (lost && !this.isLost) this.toast("The server has stopped. The scene can still be looked at.", 1e9);
    if (!lost && this.isLost) this.toast("The server is back.");
    this.isLost = lost;
  }

  trouble(title, text = "") {
    const box = this.find(".trouble");
    box.hidden = !title;
    box.querySelector("strong").textContent = title ?? "";
    box.querySelector("pre").textContent = text;
  }

  toast(text, stays = 2200) {
    const note = this.find(".toast");
    note.textContent = text;
    note.hidden = false;
    clearTimeout(this.noteTimer);
    this.noteTimer = setTimeout(() => { note.hidden = true; }, Math.min(stays, 2 ** 31 - 1));
  }

  get aspect() { return this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight); }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2), { clientWidth, clientHeight } = this.canvas;
    const [width, height] = [Math.max(1, Math.round(clientWidth * ratio)), Math.max(1, Math.round(clientHeight * ratio))];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.changed();
    }
  }

  // Draw again, and put right all that follows from the state
  changed(moving = false) {
    const { camera } = this.state, away = size(minus(camera.position, camera.look_at));
    if (size(minus(camera.look_at, this.graphics.origin)) > REACH * away) this.graphics.rebase([...camera.look_at]);
    this.film.changed(moving);
    this.marks();
    if (!moving) this.panel();
  }

  panel() {
    listBodies(this.find(".bodies"), this.scene, this.state, {
      edits: this.server?.edits ?? false, restyle: (light) => this.restyle(light), select: (item) => this.select(item),
    });
    const { section } = this.state, [low, high] = section ? reach(this.scene.bounds, section.normal) : [0, 1];
    showSection(this.root, this.state, section ? (section.offset - low) / (high - low) : 0.5);
    this.find("[name=xray]").checked = this.state.xray;
    this.find("[name=measure]").checked = this.state.measuring;
    showDetails(this.root, this.state);
  }

  marks() {
    const { clientWidth, clientHeight } = this.canvas, handle = this.find(".handle"), { section, camera } = this.state;
    drawMarks(this.find(".overlay"), this.state, clientWidth, clientHeight);
    const at = section && onScreen(camera, handlePoint(section, this.scene), clientWidth, clientHeight);
    handle.hidden = !at;
    if (at) { handle.style.left = `${at[0]}px`; handle.style.top = `${at[1]}px`; }
  }

  restyle(light = false) {
    this.graphics.restyle(this.state);
    if (!light) return this.changed();
    this.film.changed();
  }

  setCamera(camera, moving) {
    this.state.camera = camera;
    this.changed(moving);
  }

  turnTo(name) { this.setCamera(namedView(this.state, this.scene, name, this.aspect), false); }

  firstAt(x, y) {
    const ratio = this.canvas.width / this.canvas.clientWidth;
    return this.picker.at(viewOf(this.state), x * ratio, y * ratio, this.canvas.width, this.canvas.height, 64);
  }

  rayAt(x, y) { return pixelRay(this.state.camera, x, y, this.canvas.clientWidth, this.canvas.clientHeight); }

  // The point seen at a place of the picture, or one at the distance of what is looked at
  pivot(x, y) {
    const { origin, direction } = this.rayAt(x, y), ratio = this.canvas.width / this.canvas.clientWidth;
    const [hit] = this.picker.at(viewOf(this.state), x * ratio, y * ratio, this.canvas.width, this.canvas.height);
    const { position, look_at } = this.state.camera, forward = minus(look_at, position), away = size(forward);
    return add(origin, direction, hit ? hit.t : away / Math.max(0.05, dot(direction, forward) / away));
  }

  // The exact engine's answer, or null where it has none; it may take long
  async exactly(ray) {
    const engine = this.server ?? this.kernel;
    try { return { ...(await engine.pick(ray, this.state)), by: engine.by ?? "engine" }; } catch (error) { this.toast(error.message); }
    return null;
  }

  // The same by the engine that the page carries, or why it has none
  async inPage(ray) {
    try {
      this.exact ??= Exact.open(this.carried, this.scene);
      return { ...(await this.exact).pick(ray, this.state), by: "page" };
    } catch (error) { return { note: error.message }; }
  }

  // What the engine says about a ray in numbers; `quiet`: nobody has just asked, so nothing scrolls
  async askTyped(quiet = false) {
    const question = { place: null, quiet };
    let ray, answer;
    try { ray = typedRay(this.root); } catch (error) { return this.toast(error.message); }
    this.question = question;
    question.ray = question.asked = ray;
    if (this.server) answer = await this.exactly(ray);
    else if (this.kernel) answer = await Promise.race([this.exactly(ray), this.kernel.patience()]) ?? { note: SILENT };
    else answer = await this.inPage(ray);
    if (this.question !== question || this.ended || !answer) return;
    if (answer.by) this.show(answer, question); else this.toast(answer.note, 6000);
  }

  byShader(ray, view, x, y, note) {
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const all = this.picker.at(view, x * ratio, y * ratio, this.canvas.width, this.canvas.height, 64);
    if (!all.length) return { found: null };
    const named = (hit) => nameOf(this.scene, this.scene.body_item[hit.body]);
    const [hit] = all, face = (h) => (h.face < 0 ? null : h.face);
    const crossings = all.map((h) => ({ name: named(h), face: face(h), t: h.t, entering: h.entering }));
    return { found: { ...hit, name: named(hit), face: face(hit), uv: face(hit) === null ? null : hit.uv, point: add(ray.origin, ray.direction, hit.t), crossings }, by: "shader", note };
  }

  // The engine answers where there is one; the shader does while a kernel is busy, and the engine's answer takes its place
  async click(x, y) {
    const ray = this.rayAt(x, y), view = viewOf(this.state), question = { place: null, asked: ray };
    this.question = question;
    showRay(this.root, ray);
    let note = "";
    if (this.server ? !this.isLost : this.kernel) {
      const exact = this.exactly(ray), late = this.server ? exact : Promise.race([exact, this.kernel.patience()]);
      const answer = await late;
      if (this.question !== question || this.ended) return;
      if (answer) return this.show(answer, question);
      note = this.server ? "" : SILENT;
      exact.then((found) => { if (found && this.question === question && !this.ended) this.show(found, question); });
    }
    if (!this.server && !this.kernel && this.carried) {
      const answer = await this.inPage(ray);
      if (this.question !== question || this.ended) return;
      if (answer.by) return this.show(answer, question);
      note = answer.note;
    }
    this.show(this.byShader(ray, view, x, y, note), question);
  }

  // Show an answer; a later one to the same question takes the place of the earlier
  show({ found, by, note }, question) {
    this.state.found = found ? { ...found, by, note, why: this.reason(found, by, question.asked) } : null;
    this.state.line = question.ray ?? null;
    if (this.state.measuring && found) this.state.measured = this.withPoint(found.point, question);
    if (!found && !question.quiet) this.toast("Nothing is there.");
    this.marks();
    showDetails(this.root, this.state);
    if (!question.quiet) this.find(".found").scrollIntoView?.({ block: "nearest" });
  }

  // Asks Python how the answer came about; null where another engine has answered, and of a cut
  reason(found, by, ray) {
    const engine = this.server ?? this.kernel;
    if (!["engine", "python"].includes(by) || found.surface === null || !engine?.why) return null;
    return async () => {
      try { return (await engine.why(ray, found.body)).text; } catch (error) { return error.message; }
    };
  }

  withPoint(point, question) {
    const before = this.state.measured;
    if (question.place !== null) return before.map((old, k) => (k === question.place ? point : old));
    const kept = before.length > 1 ? [] : before;
    question.place = kept.length;
    return [...kept, point];
  }

  async select(item) {
    this.state.selected = item;
    const numbers = item < 0 ? [] : await this.server.ask("numbers", { item });
    const change = latest(async (path, value) => {
      try {
        const scene = await this.server.ask("edit", { path, value });
        this.accept(scene, true);
      } catch (error) { this.trouble("That number is not possible.", error.message); }
    });
    showSliders(this.root, this.scene, item, numbers, change);
    this.panel();
    if (item >= 0) this.find(".editing").scrollIntoView?.({ block: "nearest" });
  }

  toggleSection() {
    this.state.section = this.state.section ? null : sectionAlong(this.state, this.scene, "y");
    this.changed();
  }

  key(key) {
    const views = Object.keys(VIEWS);
    if (key >= "1" && key <= "6") this.turnTo(views[key - 1]);
    else if (key === "f") this.do("fit");
    else if (key === "h") this.do("home");
    else if (key === "p") this.do("panel");
    else if (key === "s") this.toggleSection();
    else if (key === "x") { this.state.xray = !this.state.xray; this.changed(); }
    else if (key === "m") this.measure(!this.state.measuring);
    else if (key === "escape") { this.state.found = null; this.state.measured = []; this.changed(); }
    else return false;
    return true;
  }

  measure(on) {
    this.state.measuring = on;
    this.state.measured = [];
    if (on) this.toast("Click two points.");
    this.changed();
  }

  do(name) {
    if (name === "fit") this.setCamera(fitted(this.state.camera, this.scene.bounds, this.aspect), false);
    else if (name === "home") this.setCamera(copyOf(this.scene.camera), false);
    else if (name === "show-all") { this.state.hidden.clear(); this.state.tints.clear(); this.restyle(); }
    else if (name === "panel") {
      const bare = this.root.classList.toggle("bare");
      this.find("[data-do=panel]").setAttribute("aria-expanded", String(!bare));
      this.resize();
    } else if (name === "copy") this.copyCamera();
    else if (name === "ask") this.askTyped();
    else if (name === "save") this.save();
  }

  async copyCamera() {
    const text = cameraYaml(this.state.camera);
    try { await navigator.clipboard.writeText(text); this.toast("The camera is in the clipboard."); }
    catch { window.prompt("The camera, for the scene file:", text); }
  }

  // The picture as it stands once it is smooth
  async save() {
    this.toast("Saving …");
    await this.film.settled(16);
    this.film.show(this.film.shown);
    this.canvas.toBlob((blob) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = `${this.title}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
      this.toast(`${this.title}.png is saved.`);
    }, "image/png");
  }

  wire() {
    listen(this.canvas, {
      camera: () => this.state.camera, set: (camera, moving) => this.setCamera(camera, moving),
      click: (x, y) => this.click(x, y), pivot: (x, y) => this.pivot(x, y),
      height: () => this.canvas.clientHeight, key: (key) => this.key(key),
    });
    this.root.addEventListener("click", (event) => {
      const button = event.target.closest?.("button");
      if (button?.dataset.do) this.do(button.dataset.do);
      if (button?.dataset.view) this.turnTo(button.dataset.view);
      if (button?.dataset.axis) { this.state.section = sectionAlong(this.state, this.scene, button.dataset.axis); this.changed(); }
    });
    const on = (name, event, act) => this.find(`[name=${name}]`).addEventListener(event, (e) => act(e.target));
    on("section", "change", () => this.toggleSection());
    on("xray", "change", (box) => { this.state.xray = box.checked; this.changed(); });
    on("measure", "change", (box) => this.measure(box.checked));
    on("softness", "input", (range) => { this.state.softness = Number(range.value); this.film.changed(); });
    on("place", "input", (range) => {
      const [low, high] = reach(this.scene.bounds, this.state.section.normal);
      this.state.section.offset = low + range.value * (high - low);
      this.film.changed(true);
      this.marks();
    });
    this.find(".asking").hidden = !(this.server || this.kernel || this.carried);
    listenForRays(this.root, () => this.askTyped());
    this.wireHandle(this.find(".handle"));
    this.observer = new ResizeObserver(() => {
      this.root.classList.toggle("narrow", this.root.clientWidth < 720);
      this.resize();
    });
    this.observer.observe(this.canvas);
    this.observer.observe(this.root);
    this.resize();
    this.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      if (this.ended) return;
      if (!this.waiting.over) return this.failed(new Error(GAVE_UP));
      this.trouble("The graphics driver has stopped drawing.", "Reload the page to go on.");
    });
    const quality = this.find(".quality");
    this.timer = setInterval(() => {
      const shown = this.film.shown;
      this.waiting.update(this.film);
      if (shown) quality.textContent = this.film.moving ? `${Math.round(this.film.scale * 100)} % of full resolution while moving` : `${shown.width} × ${shown.height}, ${this.film.samples} samples a pixel`;
    }, 250);
  }

  // Give everything back
  end() {
    if (this.ended) return;
    this.ended = true;
    this.observer.disconnect();
    clearInterval(this.timer);
    clearTimeout(this.noteTimer);
    this.kernel?.end();
    this.graphics.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  wireHandle(handle) {
    let held = null;
    const move = (section) => { this.state.section = section; this.film.changed(true); this.marks(); };
    handle.addEventListener("pointerdown", (event) => { held = event.pointerId; try { handle.setPointerCapture(held); } catch { /* gone */ } });
    handle.addEventListener("pointermove", (event) => {
      if (held === null) return;
      const box = this.canvas.getBoundingClientRect();
      move(dragged(this.state.section, this.scene, this.state.camera, event.clientX - box.left, event.clientY - box.top, box.width, box.height));
    });
    for (const name of ["pointerup", "pointercancel"]) handle.addEventListener(name, () => { held = null; this.changed(); });
    handle.addEventListener("keydown", (event) => {
      const sign = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key];
      if (!sign) return;
      event.preventDefault();
      const [low, high] = reach(this.scene.bounds, this.state.section.normal);
      const offset = this.state.section.offset + 0.02 * sign * (high - low);
      move({ ...this.state.section, offset: Math.min(high, Math.max(low, offset)) });
      this.panel();
    });
  }
}

// What stands there instead where the scene cannot be traced
export function showInstead(root, message, source) {
  const box = document.createElement("div"), words = document.createElement("p");
  box.className = "instead";
  words.setAttribute("role", "alert");
  words.textContent = source ? `${message} Here is a picture of the scene instead.` : message;
  if (source) {
    const picture = document.createElement("img");
    picture.src = source;
    picture.alt = "A picture of the scene";
    box.append(picture);
  }
  box.append(words);
  root.replaceChildren(box);
  root.classList.add("bare");
}

// A viewer, or what stands there instead
export function opened(root, data, kernel = null, server = null) {
  const source = data.preview || root.querySelector(".waiting img").src;
  try { return new Viewer(root, data, kernel, server); } catch (error) { showInstead(root, error.message, source); }
  return null;
}

export function openPage() {
  const root = document.getElementById("conicoid"), data = JSON.parse(document.getElementById("conicoid-data").textContent);
  const viewer = opened(root, data);
  if (viewer) window.conicoid = viewer;
}
