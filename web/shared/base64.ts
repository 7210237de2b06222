// Bytes from base64, by the fastest way the browser has.

/** The bytes of a base64 text; white space in it is passed over. */
export async function bytesOfBase64(text: string): Promise<Uint8Array<ArrayBuffer>> {
  const native = Uint8Array as unknown as {
    fromBase64?: (text: string) => Uint8Array<ArrayBuffer>;
  };
  if (native.fromBase64) return native.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i += 1) bytes[i] = letters.charCodeAt(i);
  return bytes;
}
