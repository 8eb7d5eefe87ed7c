// The kernel behind a notebook's widget: the exact engine's answers, where one is running.
const BUSY = 4000;   // ms to wait for a kernel that has answered before
const FIRST = 1000;  // ms to wait for one that has not

export class Kernel {
  constructor(model) {
    this.model = model;
    this.asked = new Map();
    this.name = Math.random().toString(36).slice(2);  // a scene shown twice has one model
    this.count = 0;
    this.wait = FIRST;
    this.hear = (message) => this.heard(message);
    model.on("msg:custom", this.hear);
    this.ask("hello");
  }

  // A promise of the answer; without a kernel it is never kept
  ask(ask, request = null) {
    const id = `${this.name} ${++this.count}`;
    return new Promise((resolve, reject) => {
      this.asked.set(id, { resolve, reject });
      try { this.model.send?.({ ask, id, request }); } catch { /* the kernel has gone */ }
    });
  }

  heard({ id, answer, error }) {
    const asked = this.asked.get(id);
    if (!asked) return;
    this.asked.delete(id);
    this.wait = BUSY;
    if (error === undefined) asked.resolve(answer);
    else asked.reject(new Error(error));
  }

  pick(ray, state) {
    return this.ask("pick", { ...ray, hidden: [...state.hidden], section: state.section });
  }

  why(ray, body) { return this.ask("why", { ...ray, body }); }

  // Resolves when the person should wait no longer: at once, where the kernel kept silent the last time
  patience() {
    return new Promise((resolve) => setTimeout(() => { this.wait = 0; resolve(null); }, this.wait));
  }

  end() { this.model.off?.("msg:custom", this.hear); }
}
