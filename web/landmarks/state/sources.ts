// Photographs and surfaces as bytes: from the server, or from the page itself.
import { bytesOfBase64 } from '../../shared/base64';
import { meshOf, type Mesh } from '../geometry/mesh';
import type { Place } from '../types/task';

/** @throws Error with a sentence for people */
export async function blobOf(source: string, name: string): Promise<Blob> {
  if (source.startsWith('#')) {
    const text = document.getElementById(source.slice(1))?.textContent;
    if (!text) throw new Error(`${name} is missing in this page.`);
    return new Blob([await bytesOfBase64(text)]);
  }
  let reply: Response;
  try {
    reply = await fetch(source);
  } catch {
    throw new Error(`${name} cannot be fetched: the command that showed this page has ended.`);
  }
  if (!reply.ok) throw new Error(`${name} cannot be fetched: ${await reply.text()}`);
  return reply.blob();
}

export interface SurfaceSource {
  readonly mesh: Mesh;
  readonly images: readonly (ImageBitmap | null)[];
}

export async function surfaceOf({ source, images, name }: Place): Promise<SurfaceSource> {
  const mesh = meshOf(await (await blobOf(source, name)).arrayBuffer());
  const decoded = images.map(async (image) => {
    try {
      return await createImageBitmap(await blobOf(image, name), { premultiplyAlpha: 'none' });
    } catch {
      return null; // clay where the browser cannot read a texture
    }
  });
  return { mesh, images: await Promise.all(decoded) };
}
