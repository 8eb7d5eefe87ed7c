// What stands over the picture until the shader's first frame: the engine's small picture, and a line that says why.
const PATIENCE = 1500;  // ms that the shader waits for the small picture
const FRAMES = 3;       // of the browser, after which the small picture has been seen
const LONG = 600;       // ms of compiling after which it is shown

const COMPILING = "The graphics driver is compiling the shader of this scene, which can take a minute.";
const UNTIL_THEN = "Until then, this is a small picture by the engine.";

export class Waiting {
  // `source`: of the small picture, where the page has none yet
  constructor(root, source) {
    this.box = root.querySelector(".waiting");
    this.still = this.box.querySelector("img");
    this.words = this.box.querySelector("p");
    if (source) this.still.src = source;
    this.source = this.still.src;
    this.still.addEventListener("error", () => { this.still.hidden = true; });
    this.still.hidden = this.still.complete && !this.still.naturalWidth;
    this.since = performance.now();
    this.frames = 0;
    this.over = false;
    this.say(false, 0);
  }

  // Whether the shader may be compiled: some browsers show nothing new meanwhile. Asked once a frame.
  seen() {
    if (this.still.complete || performance.now() - this.since > PATIENCE) this.frames++;
    return this.over || this.frames > FRAMES;
  }

  // Say how far it is, on a page that draws already as well, where the scene has changed
  update(film) {
    const long = film.compiling && performance.now() - film.compiling > LONG;
    if (this.over) this.box.hidden = !long;
    this.say(film.frames.some(Boolean) && !film.compiling, film.share);
  }

  say(draws, share) {
    const seen = !this.still.hidden && !this.over;
    const text = draws ? `Drawing the first frame: ${Math.round(100 * share)} %` : seen ? `${COMPILING} ${UNTIL_THEN}` : COMPILING;
    if (this.words.textContent !== text) this.words.textContent = text;
  }

  end() {
    this.over = true;
    this.box.hidden = true;
    this.still.hidden = true;
    this.still.removeAttribute("src");
  }
}
