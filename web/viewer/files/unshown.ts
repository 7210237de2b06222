// What a file says of its surfaces that the page does not show: one sentence names all of it.
import { isEntry, numberIn, numbersIn, objectIn, type Entry, type GltfDocument } from './document';
import { toonPropertiesOf } from './toon';

// Extensions of glTF, the factor that turns each of them on, and what people call it.
const FACTORS: readonly (readonly [extension: string, factor: string, name: string])[] = [
  ['KHR_materials_clearcoat', 'clearcoatFactor', 'clear coat'],
  ['KHR_materials_sheen', 'sheenColorFactor', 'sheen'],
  ['KHR_materials_transmission', 'transmissionFactor', 'transmission'],
  ['KHR_materials_diffuse_transmission', 'diffuseTransmissionFactor', 'diffuse transmission'],
  ['KHR_materials_subsurface', 'scatterDistance', 'subsurface scattering'],
  ['KHR_materials_iridescence', 'iridescenceFactor', 'iridescence'],
  ['KHR_materials_anisotropy', 'anisotropyStrength', 'anisotropy'],
];

/** What is not shown of the materials that some primitives have, as a sentence; none for nothing. */
export function unshownIn(file: GltfDocument, materials: Iterable<number>): string[] {
  const names = new Set<string>();
  for (const number of materials) {
    const entry = file.items('materials')[number];
    if (!isEntry(entry)) continue;
    const extensions = objectIn(entry, 'extensions');
    for (const [extension, factor, name] of FACTORS)
      if (isOn(objectIn(extensions, extension)[factor])) names.add(name);
    unshownOfToon(file, number, extensions).forEach((name) => names.add(name));
  }
  if (names.size === 0) return [];
  const listed = new Intl.ListFormat('en-GB').format([...names].sort());
  return [`${file.name}: ${listed} of its materials ${names.size > 1 ? 'are' : 'is'} not shown.`];
}

function unshownOfToon(file: GltfDocument, number: number, extensions: Entry): string[] {
  const one = objectIn(extensions, 'VRMC_materials_mtoon');
  const zero = toonPropertiesOf(file, number);
  const [numbers, colours, textures] = ['floatProperties', 'vectorProperties', 'textureProperties']
    .map((key) => objectIn(zero, key)) as [Entry, Entry, Entry];
  const glows = (colour: readonly number[]) => colour.slice(0, 3).some((part) => part > 0);
  const outlined = ![undefined, 'none'].includes(one['outlineWidthMode'] as string | undefined);
  const found = {
    outlines:
      (outlined && isOn(one['outlineWidthFactor'])) ||
      (numberIn(numbers, '_OutlineWidthMode', 0) > 0 && numberIn(numbers, '_OutlineWidth', 0.5) > 0),
    'rim light':
      isOn(one['parametricRimColorFactor']) ||
      glows(numbersIn(colours, '_RimColor', [0, 0, 0, 1])),
    matcap:
      ('matcapTexture' in one && glows(numbersIn(one, 'matcapFactor', [1, 1, 1]))) ||
      '_SphereAdd' in textures,
    'moving textures': [
      ...['uvAnimationScrollXSpeedFactor', 'uvAnimationScrollYSpeedFactor'],
      'uvAnimationRotationSpeedFactor',
    ].some((key) => isOn(one[key])) ||
      ['_UvAnimScrollX', '_UvAnimScrollY', '_UvAnimRotation'].some((key) => isOn(numbers[key])),
  };
  return Object.entries(found).flatMap(([name, there]) => (there ? [name] : []));
}

/** Whether a number, or one of several, is not 0. */
function isOn(factor: unknown): boolean {
  const parts: readonly unknown[] = Array.isArray(factor) ? factor : [factor];
  return parts.some((part) => typeof part === 'number' && part !== 0);
}
