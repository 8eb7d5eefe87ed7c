// A page in which a scene is typed. Each change is read by Python; a ray that has been asked is asked anew.
import { showRay, typedRay } from "./asking.js";
import { PythonInPage, ServedBrain } from "./brain.js";
import { fragmentOf, ofFragment } from "./links.js";
import { latest } from "./editing.js";
import { opened } from "./main.js";
import { element } from "./panel.js";

const PAUSE = 350;  // ms without a key after which a text is read
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class Playground {
  constructor(root, viewer, brain, data) {
    Object.assign(this, { root, viewer, brain, examples: data.examples });
    this.find = (selector) => root.querySelector(selector);
    this.text = this.find("[name=scene]");
    this.camera = null;  // that the last good text said
    this.shown = data.scene;
    this.read = latest((fresh) => this.readText(fresh));
    this.wire();
    this.begin(data.text);
  }

  // The scene of the address, of the server, or the first example
  async begin(given) {
    try {
      const linked = await ofFragment(location.hash);
      if (linked) return this.take(linked.text, linked.ray);
    } catch { this.viewer.toast("The link holds no scene that can be read.", 6000); }
    if (given === null) this.take(this.examples[0].text, this.examples[0].ray);
    else this.take(given, "");
  }

  // Another scene in place of what is typed; `ray`: six numbers, or nothing
  take(text, ray) {
    this.text.value = text;
    this.ray(ray);
    this.number();
    return this.read(true);
  }

  ray(text) {
    const found = text.split(/[\s,]+/).filter(Boolean).map(Number);
    const [origin, direction] = [found.slice(0, 3), found.slice(3)];
    showRay(this.root, found.length === 6 && found.every(Number.isFinite) ? { origin, direction } : { origin: [], direction: [] });
  }

  // Ask Python what the text says; `fresh`: a scene that has not been looked at yet
  async readText(fresh) {
    const text = this.text.value, { viewer, brain } = this;
    let answer;
    try { answer = await brain.ask("typed", { text }); } catch (error) { return this.say(error.message, true); }
    if (answer.problems) return this.problems(answer);
    const { camera } = answer.scene, turned = answer.camera && !same(camera, this.camera);
    this.camera = camera;
    brain.number = answer.number;
    try { if (!same(this.shown, answer.scene)) viewer.accept(answer.scene, !fresh && !turned); } catch (error) { return this.say(error.message, true); }
    this.shown = answer.scene;
    this.problems({ problems: [], count: 0 });
    if (this.asked()) await viewer.askTyped(true);
    if (this.text.value === text) this.remember(text);  // else a later one is on its way
  }

  // Has a ray been given?
  asked() {
    try { return typedRay(this.root); } catch { return null; }
  }

  problems({ problems, count }) {
    const list = this.find(".problems"), wrong = new Set(problems.map((problem) => problem.line));
    list.replaceChildren(...problems.map((problem) => {
      const { line, column, where, message } = problem, place = line ? `${line}:${column}` : "";
      const text = [place, where, message].filter(Boolean).join("  ");
      const button = element("button", {}, text);
      button.addEventListener("click", () => this.goTo(line, column));
      return element("li", {}, line ? button : text);
    }));
    list.hidden = !problems.length;
    const bodies = this.viewer.scene.body_item.length;
    if (count) this.say(`${count} ${count === 1 ? "mistake" : "mistakes"}; the last good scene is shown.`, true);
    else this.say(`${bodies.toLocaleString("en")} ${bodies === 1 ? "body" : "bodies"}, as typed.`);
    this.number(wrong);
  }

  say(text, bad = false) {
    const line = this.find(".reading");
    line.textContent = text;
    line.classList.toggle("bad", bad);
  }

  // The caret to a place of the text
  goTo(line, column) {
    const lines = this.text.value.split("\n"), before = lines.slice(0, line - 1).join("\n").length + (line > 1);
    const at = before + column - 1, end = before + (lines[line - 1] ?? "").length;
    this.text.focus();
    this.text.setSelectionRange(at, Math.max(at, end));
    this.text.scrollTop = Math.max(0, (line - 4) * this.text.scrollHeight / Math.max(1, lines.length));
  }

  // Numbers beside the lines
  number(wrong = new Set()) {
    const count = this.text.value.split("\n").length;
    const numbers = Array.from({ length: count }, (_, k) => element("span", wrong.has(k + 1) ? { class: "bad" } : {}, `${k + 1}\n`));
    this.find(".numbers").replaceChildren(...numbers);
    this.follow();
  }

  follow() { this.find(".numbers").scrollTop = this.text.scrollTop; }

  // The address holds what is shown, so that the page can be loaded anew
  async remember(text) {
    try { history.replaceState(null, "", await fragmentOf(text, this.asked())); } catch { /* too long, or no history here */ }
  }

  async link() {
    try {
      const fragment = await fragmentOf(this.text.value, this.asked()), address = `${location.href.split("#")[0]}${fragment}`;
      history.replaceState(null, "", fragment);
      try { await navigator.clipboard.writeText(address); this.viewer.toast("The link is in the clipboard."); }
      catch { window.prompt("The link to this scene and ray:", address); }
    } catch (error) { this.viewer.toast(error.message, 6000); }
  }

  wire() {
    const choice = this.find("[name=example]");
    choice.append(element("option", { value: "" }, "choose …"), ...this.examples.map(({ name }, k) => element("option", { value: String(k) }, name)));
    choice.value = "";
    choice.addEventListener("change", () => {
      if (choice.value === "") return;
      const { text, ray } = this.examples[Number(choice.value)];
      choice.value = "";
      this.take(text, ray);
    });
    let waiting = 0;
    this.text.addEventListener("input", () => {
      clearTimeout(waiting);
      waiting = setTimeout(() => this.read(false), PAUSE);
      this.number();
    });
    this.text.addEventListener("scroll", () => this.follow());
    this.text.addEventListener("keydown", (event) => { if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) this.read(false); });
    this.find("[data-do=link]").addEventListener("click", () => this.link());
    window.addEventListener("hashchange", () => this.begin(this.text.value));
  }
}

export function openPlayground() {
  const root = document.getElementById("conicoid"), data = JSON.parse(document.getElementById("conicoid-data").textContent);
  const line = root.querySelector(".reading"), coming = root.querySelector(".coming");
  const hears = (text, failed) => {
    coming.hidden = text === null;
    coming.textContent = text ?? "";
    coming.classList.toggle("bad", Boolean(failed));
    if (failed) line.textContent = "";
  };
  const brain = data.python ? new PythonInPage(data.python, hears) : new ServedBrain(data.served);
  const viewer = opened(root, data, null, brain);
  if (!viewer) return;
  window.conicoid = viewer;
  window.playground = new Playground(root, viewer, brain, data);
}
