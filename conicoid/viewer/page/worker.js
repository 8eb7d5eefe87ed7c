// Python beside the page: Pyodide, NumPy, and Conicoid from its wheel. What it is asked before it has come, waits.
const STEPS = ["Python", "NumPy", "Conicoid"];
let answering;

function tell(step) { postMessage({ progress: `Python is on its way to this page: ${STEPS[step]} (${step + 1} of ${STEPS.length}). The picture can be turned already.` }); }

async function start({ pyodide, packages, wheel }) {
  tell(0);
  const address = new URL(pyodide, self.location.href).href;
  const { loadPyodide } = await import(`${address}pyodide.mjs`);
  const python = await loadPyodide({ indexURL: address });
  tell(1);
  await python.loadPackage(packages, { messageCallback: () => {} });
  tell(2);
  const answer = await fetch(new URL(wheel, self.location.href));
  if (!answer.ok) throw new Error(`${wheel}: ${answer.status}`);
  python.unpackArchive(await answer.arrayBuffer(), "wheel");
  const ask = python.runPython("from conicoid.viewer.playground import in_page\nin_page()");
  postMessage({ progress: null });
  return ask;
}

self.onmessage = async ({ data }) => {
  if (data.start) {
    answering = start(data.start);
    answering.catch((error) => postMessage({ progress: `Python does not run here: ${String(error.message).trim().split("\n").at(-1)}`, failed: true }));
    return;
  }
  let ask;
  try { ask = await answering; } catch { return; }
  let answer;
  try { answer = ask(data.name, data.body); } catch (error) { answer = JSON.stringify({ error: String(error.message).trim().split("\n").at(-1) }); }
  postMessage({ id: data.id, answer });
};
