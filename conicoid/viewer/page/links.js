// A scene in the address of its page: compressed, after the #, so that no server reads it.
const LONGEST = 30000;  // letters of an address that all browsers take

async function piped(bytes, stream) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function fragmentOf(text, ray) {
  const bytes = await piped(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  let letters = "";
  for (const byte of bytes) letters += String.fromCharCode(byte);
  const packed = btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  const fragment = `#scene=${packed}${ray ? `&ray=${[...ray.origin, ...ray.direction].join(",")}` : ""}`;
  if (fragment.length > LONGEST) throw new Error(`This scene is too long for a link: it takes ${fragment.length} letters, and ${LONGEST} are allowed.`);
  return fragment;
}

// { text, ray }, or null where an address holds no scene
export async function ofFragment(fragment) {
  const found = new URLSearchParams(fragment.slice(1)), packed = found.get("scene");
  if (!packed) return null;
  const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
  const text = new TextDecoder().decode(await piped(bytes, new DecompressionStream("deflate-raw")));
  return { text, ray: found.get("ray")?.split(",").join(" ") ?? "" };
}
