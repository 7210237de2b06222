// What Python put into the page, or beside it: a description in JSON and a GLB for each model.
import type { Loop, Model, Scene, Services } from '../types/model';
import type { ViewState } from '../types/state';
import { isEntry, type Entry } from './document';
import { openFile, type Known } from './open';
import { inflated } from './packed';

const ID = 'elastomorph-scene';
// A GLB counts its bytes in 32 bits.
const LARGEST = 2 ** 32;
const ROLES: readonly string[] = ['rig', 'method', 'truth'] satisfies Model['role'][];

/**
 * The scene of a page, or null where it has none.
 *
 * @throws Error with a sentence for people
 */
export async function loadScene(document: Document): Promise<Scene | null> {
  const text = document.getElementById(ID)?.textContent;
  if (!text?.trim()) return null;
  return sceneOf(document, described(text));
}

/**
 * The scene of a description, with the models that are at its addresses.
 *
 * @throws Error with a sentence for people
 */
export async function sceneOf(document: Document, description: unknown): Promise<Scene> {
  const stored = isEntry(description) ? description : {};
  const entries = Array.isArray(stored['models']) ? stored['models'].filter(isEntry) : [];
  if (entries.length === 0)
    throw new Error('This page describes no model. Make it again with "elastomorph view".');
  const loops = loopsOf(stored['loops']);
  const diameter = stored['diameter'];
  const known: Known = { loops, ...(typeof diameter === 'number' && diameter > 0 && { diameter }) };
  const models: Model[] = [];
  // One after another: two at a time would need the memory of two files, and gain nothing.
  for (const entry of entries) models.push(await modelOf(document, entry, known));
  requireAlike(models);
  const title = typeof stored['title'] === 'string' ? stored['title'] : 'elastomorph';
  return {
    title,
    name: typeof stored['name'] === 'string' ? stored['name'] : title,
    unit: typeof stored['unit'] === 'string' ? stored['unit'] : '',
    models,
    start: isEntry(stored['start']) ? (stored['start'] as Partial<ViewState>) : {},
    services: isEntry(stored['services']) ? (stored['services'] as Services) : {},
  };
}

function described(text: string): Entry {
  let stored: unknown;
  try {
    stored = JSON.parse(text);
  } catch {
    throw new Error('What this page is to show is damaged. Make it again with "elastomorph view".');
  }
  if (!isEntry(stored) || typeof stored['version'] !== 'number')
    throw new Error(
      'What this page is to show has no version. Make it again with "elastomorph view".',
    );
  if (stored['version'] > 1)
    throw new Error(
      `This page was made for a later viewer (version ${stored['version']}). Make it again ` +
        'with "elastomorph view".',
    );
  return stored;
}

async function modelOf(document: Document, entry: Entry, known: Known): Promise<Model> {
  const name = typeof entry['name'] === 'string' ? entry['name'] : 'model';
  const role = (ROLES.includes(String(entry['role'])) ? entry['role'] : 'rig') as Model['role'];
  const bytes = await bytesAt(document, String(entry['glb'] ?? ''), name);
  return openFile(name, bytes, { ...known, name, role });
}

async function bytesAt(document: Document, address: string, name: string): Promise<ArrayBuffer> {
  if (address.startsWith('#')) {
    const element = document.getElementById(address.slice(1));
    const text = element?.textContent?.trim();
    if (!element || !text)
      throw new Error(
        `${name}: the page holds no file for it. Make the page again with "elastomorph view".`,
      );
    const bytes = await inflated(text, LARGEST).catch(() => {
      throw new Error(
        `${name}: its bytes in the page are damaged. Make the page again with "elastomorph view".`,
      );
    });
    element.textContent = ''; // the text is larger than the file, and not needed again
    return bytes.buffer;
  }
  const { origin, href } = new URL(address, document.baseURI);
  if (origin !== new URL(document.baseURI).origin)
    throw new Error(`${name}: ${href} is outside this page, which loads nothing from elsewhere.`);
  const answer = await fetch(href).catch(() => {
    throw new Error(`${name}: no answer from ${href}. Is "elastomorph view" still running?`);
  });
  if (!answer.ok)
    throw new Error(
      `${name}: ${href} answered ${answer.status}. Start "elastomorph view" again and open ` +
        'the address it prints.',
    );
  return answer.arrayBuffer();
}

function loopsOf(stored: unknown): Loop[] {
  if (!Array.isArray(stored)) return [];
  return stored
    .filter(isEntry)
    .flatMap(({ closed, vertices }) =>
      Array.isArray(vertices) && vertices.every((v) => Number.isInteger(v) && v >= 0)
        ? [{ closed: closed === true, vertices: vertices as number[] }]
        : [],
    );
}

function requireAlike(models: readonly Model[]): void {
  const first = models[0]!;
  const other = models.find((model) => model.neutral.length !== first.neutral.length);
  if (!other) return;
  const [one, two] = [first, other].map((model) => (model.neutral.length / 3).toLocaleString('en'));
  throw new Error(
    `${other.name} has ${two} vertices and ${first.name} ${one}: only faces with the same ` +
      'vertices can be compared.',
  );
}
