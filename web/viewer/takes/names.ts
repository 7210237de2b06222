// What the weights of a face are called, in all spellings: as elastomorph.rig.performance.naming.
// Nothing is guessed. A name that no table has means only itself.
import { ARKIT } from '../interface/names/arkit';

const DIRECTIONS = ['jawLeft', 'jawRight', 'mouthLeft', 'mouthRight'];
const SIDES = ['Left', 'Right'] as const;
const SIDED = [
  ...['browInnerUp', 'cheekPuff'], // on rigs, though not with ARKit
  ...ARKIT.filter((name) => name.endsWith('Left') && !DIRECTIONS.includes(name)).map((name) =>
    name.slice(0, -4),
  ),
];

/** A shape, and those that make it up together: its halves, or what a preset of VRM is in ARKit. */
export const WHOLES: readonly (readonly [string, readonly string[]])[] = [
  ...SIDED.map((shape) => [shape, SIDES.map((side) => shape + side)] as const),
  ['blink', ['eyeBlinkLeft', 'eyeBlinkRight']],
  ['blinkLeft', ['eyeBlinkLeft']],
  ['blinkRight', ['eyeBlinkRight']],
  ['lookUp', ['eyeLookUpLeft', 'eyeLookUpRight']],
  ['lookDown', ['eyeLookDownLeft', 'eyeLookDownRight']],
  ['lookLeft', ['eyeLookOutLeft', 'eyeLookInRight']],
  ['lookRight', ['eyeLookInLeft', 'eyeLookOutRight']],
];

// Preset expressions of VRM 1.0 and what VRM 0 calls them.
const VRM =
  'blink=Blink blinkLeft=Blink_L blinkRight=Blink_R lookUp=LookUp lookDown=LookDown ' +
  'lookLeft=LookLeft lookRight=LookRight aa=A ih=I ou=U ee=E oh=O happy=Joy angry=Angry ' +
  'sad=Sorrow relaxed=Fun surprised=Surprised neutral=Neutral';

const SHAPES = new Map([...ARKIT, ...SIDED].map((shape) => [shape.toLowerCase(), shape]));
for (const shape of SIDED) {
  for (const side of SIDES) {
    SHAPES.set((shape + side).toLowerCase(), shape + side);
    SHAPES.set(`${shape}_${side[0]}`.toLowerCase(), shape + side);
  }
}
for (const pair of VRM.split(' ')) {
  const [preset = '', old = ''] = pair.split('=');
  SHAPES.set(preset.toLowerCase(), preset).set(old.toLowerCase(), preset);
}

const ROTATION = /^(head|lefteye|righteye)(yaw|pitch|roll)$/i;

/** Where the own name begins behind a node or namespace: `shapes.jawOpen`, `head:jawOpen`. */
export function nodeOf(name: string): string {
  return name.slice(0, Math.max(name.lastIndexOf(':'), name.lastIndexOf('.')) + 1);
}

/** The shape that a name stands for, in ARKit's spelling; undefined where no table has it. */
export function shapeOf(name: string): string | undefined {
  const bare = name.slice(name.lastIndexOf(':') + 1);
  const own = bare.slice(bare.lastIndexOf('.') + 1);
  return SHAPES.get(name.toLowerCase()) ?? SHAPES.get(own.toLowerCase());
}

/** Whether a name is an angle of the head or an eye, as Live Link Face records them. */
export function isRotation(name: string): boolean {
  return ROTATION.test(name);
}
