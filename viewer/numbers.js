// Numbers of the page: { data: base64 of 16-bit whole numbers, scale, offset } or { data: base64 of 32-bit floats }.
export function floats(packed) {
  const text = atob(packed.data);
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  if (packed.scale === undefined) return new Float32Array(bytes.buffer);
  return Float32Array.from(new Int16Array(bytes.buffer), (value) => packed.offset + packed.scale * value);
}
