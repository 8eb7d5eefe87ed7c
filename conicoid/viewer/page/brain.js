// Who answers a playground: the Python that serves the page, or one that runs in the page, in a worker of its own.
import { Server } from "./live.js";

// The rays of a page ask the scene that it shows
const request = (ray, state, number) => ({ ...ray, hidden: [...state.hidden], section: state.section, number });

export class ServedBrain extends Server {
  constructor(served) {
    super(served);
    this.edits = false;
    this.number = 0;
  }

  pick(ray, state) { return this.ask("pick", request(ray, state, this.number)); }

  why(ray, body) { return this.ask("why", { ...ray, body, number: this.number }); }
}

export class PythonInPage {
  // `place`: where Python, its packages and Conicoid are; hears(text) is called as it comes, with null at the end
  constructor(place, hears) {
    this.edits = false;
    this.by = "python";
    this.number = 0;
    this.asked = new Map();
    this.count = 0;
    this.worker = new Worker("worker.js", { type: "module" });
    this.worker.onmessage = ({ data }) => {
      if (data.progress !== undefined) return hears(data.progress, data.failed);
      const { resolve, reject } = this.asked.get(data.id);
      this.asked.delete(data.id);
      const { answer, error } = JSON.parse(data.answer);
      if (error === undefined) resolve(answer); else reject(new Error(error));
    };
    this.worker.onerror = (event) => hears(`Python does not run here (${event.message ?? "its program did not come"}).`, true);
    this.worker.postMessage({ start: place });
  }

  // What is asked before Python has come is answered when it has
  ask(name, body) {
    const id = ++this.count;
    return new Promise((resolve, reject) => {
      this.asked.set(id, { resolve, reject });
      this.worker.postMessage({ id, name, body: JSON.stringify(body) });
    });
  }

  pick(ray, state) { return this.ask("pick", request(ray, state, this.number)); }

  why(ray, body) { return this.ask("why", { ...ray, body, number: this.number }); }

  watch() { /* nobody else changes the scene */ }
}
