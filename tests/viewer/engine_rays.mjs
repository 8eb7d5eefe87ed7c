// What the page's engine says about rays: node engine_rays.mjs PAGE_MODULE CASES, answers with every float as its bits.
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [module, cases] = process.argv.slice(2);
const { Exact, bitsOf, decodedScene } = await import(pathToFileURL(module));

function bits(value) {
  if (typeof value === "number") return Number.isNaN(value) ? "nan" : bitsOf(value).toString();
  if (Array.isArray(value)) return value.map(bits);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, bits(item)]));
}

const answers = [];
for (const { scene, engine, rays } of JSON.parse(readFileSync(cases, "utf8"))) {
  const exact = await Exact.open(engine, decodedScene(scene));
  answers.push(rays.map(({ hidden, section, ...ray }) => {
    try { return bits(exact.pick(ray, { hidden: new Set(hidden), section })); } catch (error) { return { error: error.message }; }
  }));
}
process.stdout.write(JSON.stringify(answers));
