// Opens a file with a face: its own paths where elastomorph wrote it, straight ones otherwise.
import { movedVertices } from '../rig/surface';
import type { Model } from '../types/model';
import { readClips } from './clips';
import { openContainer } from './container';
import { diameterOf } from './diameter';
import { GltfDocument, listed, objectIn, type Entry } from './document';
import { headOf } from './head';
import { readMorphs, storedIn } from './morphs';
import { placedMeshes } from './nodes';
import { dressedParts, sortedParts } from './parts';
import { inOne, readPolygons, plainEdges } from './polygons';
import { seamsOf } from './seams';
import { readSkins } from './skins';
import { readSurface, type Surface, targetNamesOf } from './surface';
import { unshownIn } from './unshown';
import { unpackedContent } from './unpacking/content';

/**
 * Least cosine between the normals at a texture seam. A file with images may have been cut apart
 * along them by another program: each side then has the normal of its own half.
 */
const SEAM_OF_SKINS = 0.35;

/** What is known of a model before its file is read. */
export type Known = Partial<Pick<Model, 'name' | 'role' | 'loops' | 'diameter'>>;

/** What targets move; all where nothing moves. A body below the face is no part of its D. */
function movedPoints({ neutral, targets }: Surface): Float32Array {
  const moved = movedVertices(targets, neutral.length / 3);
  if (moved.length < 2) return neutral;
  return Float32Array.from(moved.flatMap((v) => [...neutral.subarray(3 * v, 3 * v + 3)]));
}

/**
 * The face in a .glb (or a .gltf with everything inside).
 *
 * @throws Error with a sentence that names the file and what to do
 */
export async function openFile(
  name: string,
  bytes: ArrayBuffer,
  known: Known = {},
): Promise<Model> {
  const file = new GltfDocument(await unpackedContent(await openContainer(name, bytes)));
  const meshes = placedMeshes(file);
  const read = readSurface(file, meshes);
  const numbers = [...new Set(meshes.map(({ mesh }) => mesh))];
  const stored = storedIn(
    numbers.map((number) => {
      const shown = listed(file, 'nodes', meshes.find(({ mesh }) => mesh === number)?.node);
      const mesh = file.item('meshes', number, 'a node');
      return { ...mesh, extras: { ...objectIn(shown, 'extras'), ...objectIn(mesh, 'extras') } };
    }),
    (mesh) => targetNamesOf(file, mesh),
  );
  const surface = stored.length === meshes.length ? await inOne(read, stored) : read;
  const whole = surface === read ? stored[0] : (stored[0]?.['whole'] as Entry);
  const one = surface !== read || meshes.length === 1;
  const written = one ? whole?.['surface'] : undefined;
  const polygons = await readPolygons(written, surface);
  const skins = await readSkins(file, surface.colours !== null);
  const seams = skins ? seamsOf(surface, SEAM_OF_SKINS) : (polygons?.seams ?? seamsOf(surface));
  const used = new Set(surface.pieces.flatMap(({ material }) => material ?? []));
  const described = readMorphs(stored, surface.targetNames);
  return {
    name: known.name ?? name.replace(/\.(glb|gltf|vrm)$/i, ''),
    role: known.role ?? 'rig',
    neutral: surface.neutral,
    ...(skins
      ? dressedParts(file, surface, skins.ofMaterial)
      : sortedParts(file, surface, polygons, seams)),
    uv: surface.uv,
    colours: surface.colours,
    fileNormals: skins ? surface.normals : null,
    head: skins ? headOf(surface) : null,
    seams,
    edges: polygons?.edges ?? plainEdges(surface, seams),
    loops: known.loops ?? [],
    targets: surface.targets,
    ...described,
    clips: readClips(file, meshes, surface.targetNames, described),
    diameter: known.diameter ?? diameterOf(written ? surface.neutral : movedPoints(surface)),
    bytes: file.size,
    notes: [...(skins?.notes ?? []), ...unshownIn(file, used)],
    file: new Blob([bytes]),
  };
}
