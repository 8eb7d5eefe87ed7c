// The server that serves this page: the exact engine's answers, the file as it changes, numbers to edit.

export class Server {
  constructor(served) {
    this.version = served.version;
    this.edits = true;
  }

  async ask(name, body) {
    const options = body === undefined ? {} : { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
    const answer = await fetch(name, { ...options, cache: "no-store" });
    const data = await answer.json();
    if (!answer.ok) throw new Error(data.error ?? `the server answered ${answer.status}`);
    return data;
  }

  pick(ray, state) {
    return this.ask("pick", { ...ray, hidden: [...state.hidden], section: state.section });
  }

  why(ray, body) { return this.ask("why", { ...ray, body }); }

  // Ask again and again whether the file has changed; calls changed(answer) with a scene, or with trouble in the file
  watch(changed, lost) {
    const look = async () => {
      try {
        const { version, trouble } = await this.ask("version");
        lost(false);
        if (version !== this.version) {
          const answer = trouble ? { trouble } : { scene: await this.ask("scene") };
          this.version = version;
          changed(answer);
        }
      } catch { lost(true); }
      setTimeout(look, 500);
    };
    setTimeout(look, 500);
  }
}
