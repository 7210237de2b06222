// Opens what only the command that shows this page can read: its bytes go there and come back.
import { sceneOf } from '../../files/scene';
import { ask } from '../../methods/asking';
import { joined, joins, type Receiver } from './models';
import { pathOf, type Opener } from './opening';

const MESHES = /\.(obj|ply)$/i;
const RIGS = /\.(fbx|usd[acz]?)$/i;
const CHARACTERS = /\.vrm$/i; // which the page reads itself where nobody else does
const BUFFERS = /\.bin$/i; // without which a .gltf is empty
const BESIDE = /\.(mtl|png|jpe?g|tga|bmp|bin|toml|json)$/i;
const CHANCE = /(^|\/)(\.|Thumbs\.db$|desktop\.ini$)/; // what systems leave in folders
const MOST_BYTES = 2 ** 31;
const MOST_FILES = 2000;

/** Folders of meshes with a neutral and targets, VRM, FBX and USD files. */
export function servedOpener(receiver: Receiver, busy: (words: string) => void): Opener {
  const address = () => receiver.scene()?.services.open;
  return {
    accepts: '.obj,.ply,.vrm,.fbx,.usd,.usda,.usdc,.usdz',
    fits(files) {
      const inFolders = files.filter((file) => pathOf(file).includes('/'));
      if (inFolders.length > 0) {
        const top = pathOf(inFolders[0]!).split('/')[0]!;
        return inFolders.filter((file) => pathOf(file).startsWith(`${top}/`));
      }
      const served = address() !== undefined;
      const inParts = served && files.some(({ name }) => BUFFERS.test(name));
      const mine = ({ name }: File) =>
        RIGS.test(name) ||
        (served && CHARACTERS.test(name)) ||
        (inParts && /\.gltf$/i.test(name));
      const rig = files.find(mine);
      if (rig) return [rig, ...files.filter(({ name }) => BESIDE.test(name))];
      const meshes = files.filter(({ name }) => MESHES.test(name));
      return meshes.length > 0
        ? files.filter(({ name }) => MESHES.test(name) || BESIDE.test(name))
        : [];
    },
    async open(files) {
      const sent = files.filter((file) => !CHANCE.test(pathOf(file)));
      const service = address();
      if (service === undefined) throw new Error(elsewhere(sent[0] ?? files[0]!));
      const size = sent.reduce((sum, file) => sum + file.size, 0);
      if (size > MOST_BYTES || sent.length > MOST_FILES) {
        throw new Error(
          `${sent.length.toLocaleString('en')} files of ${(size / 1e9).toFixed(1)} GB are more ` +
            'than a page may send: run "elastomorph view" with their folder instead.',
        );
      }
      const listed = sent.map((file) => [pathOf(file), file.size]);
      const body = new Blob([`${JSON.stringify({ files: listed })}\n`, ...sent]);
      const done = await ask(service, body, (words) => busy(`${words}…`));
      const next = await sceneOf(document, done['scene']);
      const now = receiver.scene();
      if (joins(now, next.models[0])) await receiver.replace(...joined(now, next.models[0]!));
      else await receiver.replace(next, []);
    },
  };
}

function elsewhere(file: File): string {
  const path = pathOf(file);
  const folder = path.includes('/') ? path.split('/')[0]! : 'FOLDER';
  const what = RIGS.test(file.name) ? file.name : folder;
  return (
    `${path}: a page that stands alone opens GLB files. Run "elastomorph view ${what}", whose ` +
    `page opens it, or "elastomorph export ${what} -o face.glb".`
  );
}
