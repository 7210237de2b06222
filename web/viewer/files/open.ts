// Opens a file with a face: its own paths where elastomorph wrote it, straight ones otherwise.
import { slidersOf } from '../rig/pose';
import type { Model } from '../types/model';
import { readClips } from './clips';
import { openContainer } from './container';
import { diameterOf } from './diameter';
import { GltfDocument, isEntry } from './document';
import { readMorphs } from './morphs';
import { placedMeshes } from './nodes';
import { sortedParts } from './parts';
import { readPolygons, triangleEdges } from './polygons';
import { seamsOf } from './seams';
import { readSurface } from './surface';

/** What is known of a model before its file is read. */
export type Known = Partial<Pick<Model, 'name' | 'role' | 'loops' | 'diameter'>>;

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
  const file = new GltfDocument(await openContainer(name, bytes));
  const meshes = placedMeshes(file);
  const surface = readSurface(file, meshes);
  const stored = meshes.length === 1 ? extrasOf(file, meshes[0]!.mesh) : undefined;
  const polygons = await readPolygons(stored?.['surface'], surface);
  const seams = polygons?.seams ?? seamsOf(surface);
  const described = readMorphs(stored, surface.targetNames);
  return {
    name: known.name ?? name.replace(/\.(glb|gltf)$/i, ''),
    role: known.role ?? 'rig',
    neutral: surface.neutral,
    ...sortedParts(file, surface, polygons, seams),
    seams,
    edges: polygons?.edges ?? triangleEdges(surface, seams),
    loops: known.loops ?? [],
    targets: surface.targets,
    ...described,
    sliders: slidersOf(described),
    clips: readClips(file, meshes, surface.targetNames, described.morphs, described.correctives),
    diameter: known.diameter ?? diameterOf(surface.neutral),
    bytes: file.size,
  };
}

function extrasOf(file: GltfDocument, mesh: number): Record<string, unknown> | undefined {
  const extras = file.item('meshes', mesh, 'a node')['extras'];
  const own = isEntry(extras) ? extras['elastomorph'] : undefined;
  return isEntry(own) ? own : undefined;
}
