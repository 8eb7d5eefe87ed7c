// Conicoid's engine as WebAssembly: the kernels of the desktop, called as its Python calls them, to the same bits.
// It takes no function from here, so that nothing of JavaScript can decide a bit.
const SIZES = { f8: 8, i8: 8, i4: 4, i1: 1 };
const ARRAYS = { f8: Float64Array, i8: BigInt64Array, i4: Int32Array, i1: Int8Array };
const NOTHING = -2, MOST_SLOTS = 512;

export async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).arrayBuffer();
}

// A number as the 64 bits of a slot
const scratch = new DataView(new ArrayBuffer(8));
export function bitsOf(x) { scratch.setFloat64(0, x); return scratch.getBigInt64(0); }
export function ofBits(bits) { scratch.setBigInt64(0, bits); return scratch.getFloat64(0); }

// A whole number among the arguments of a kernel; other numbers are floats
export const whole = (n) => BigInt(n);

export class Engine {
  static async open(code) { return new Engine((await WebAssembly.instantiate(code, {})).instance.exports); }

  constructor(exports) {
    this.exports = exports;
    this.slots = this.room(8 * MOST_SLOTS);
    this.result = this.room(128);
  }

  room(size) {
    const at = this.exports.room(size) >>> 0;
    if (!at) throw new Error("The browser gives the engine no more memory.");
    return at;
  }

  // An array for kernels: of zeros, or of what is given
  array(kind, shape, values) {
    const count = shape.reduce((a, b) => a * b, 1), made = { kind, shape, count, at: this.room(SIZES[kind] * count) };
    if (values) this.view(made).set(values); else this.view(made).fill(kind === "i8" ? 0n : 0);
    return made;
  }

  // Its numbers, until memory grows
  view({ kind, at, count }) { return new ARRAYS[kind](this.exports.memory.buffer, at, count); }

  // What a kernel returns is in `result`; null where it returns nothing
  call(name, ...values) {
    const slots = [];
    for (const value of values.flat(3)) this.put(slots, value);
    new BigInt64Array(this.exports.memory.buffer, this.slots, slots.length).set(slots);
    const status = this.exports[`conicoid_page_${name}`](this.result, this.slots);
    if (status !== 0 && status !== NOTHING) throw new Error(`The engine gave up (${name}, ${status}): it has too little memory.`);
    return new DataView(this.exports.memory.buffer, this.result);
  }

  // One argument, as LLVM passes it: of an array what Numba keeps of one
  put(slots, value) {
    if (typeof value === "bigint") return slots.push(value);
    if (typeof value === "boolean") return slots.push(value ? 1n : 0n);
    if (typeof value === "number") return slots.push(bitsOf(value));
    const { kind, shape, count, at } = value, strides = [];
    let stride = SIZES[kind];
    for (const length of [...shape].reverse()) { strides.unshift(stride); stride *= length; }
    return slots.push(...[0, 0, count, SIZES[kind], at, ...shape, ...strides].map(BigInt));
  }

  // The rows of an array that a kernel has just returned
  rows(columns) {
    const result = new DataView(this.exports.memory.buffer, this.result);
    const block = result.getUint32(0, true), at = result.getUint32(24, true), count = Number(result.getBigInt64(32, true));
    const flat = Float64Array.from(new Float64Array(this.exports.memory.buffer, at, count * columns));
    this.exports.release(block);
    return Array.from({ length: count }, (_, k) => flat.subarray(columns * k, columns * k + columns));
  }
}
