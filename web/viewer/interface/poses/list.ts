// What is done to a list of poses: each time another list, in which no two have one name.
import type { NamedPose } from '../../types/state';

export type Poses = readonly NamedPose[];
type Weights = NamedPose['weights'];

export const LONGEST_NAME = 120; // letters

/** That name, or with the first number behind it that makes it a new one. */
export function freshName(all: readonly { readonly name: string }[], wanted: string): string {
  return nameBeside(new Set(all.map(({ name }) => name)), wanted);
}

function nameBeside(taken: { has(name: string): boolean }, wanted: string): string {
  if (!taken.has(wanted)) return wanted;
  const stem = wanted.replace(/ \d+$/, '');
  let number = 2;
  while (taken.has(`${stem} ${number}`)) number += 1;
  return `${stem} ${number}`;
}

/** One line without blanks around it, as a file can hold it; '' where nothing is left. */
export function cleanName(text: string): string {
  const line = text.replace(/[\p{Cc}\p{Cs}\s]+/gu, ' ').trim();
  return line.slice(0, LONGEST_NAME).replace(/\p{Cs}$/u, '').trim(); // no half of a letter
}

/** With the pose of that name, in the place of one that has it already. */
export function saved(poses: Poses, name: string, weights: Weights): Poses {
  const pose = { name, weights: rounded(weights) };
  const place = poses.findIndex((one) => one.name === name);
  return place < 0 ? [...poses, pose] : poses.with(place, pose);
}

/** Where the new name is taken, nothing changes. */
export function renamed(poses: Poses, from: string, to: string): Poses {
  if (poses.some(({ name }) => name === to)) return poses;
  return poses.map((pose) => (pose.name === from ? { ...pose, name: to } : pose));
}

export function removed(poses: Poses, name: string): Poses {
  return poses.filter((pose) => pose.name !== name);
}

/** With a copy behind the pose, and the name of the copy. */
export function duplicated(poses: Poses, name: string): readonly [Poses, string] {
  const place = poses.findIndex((pose) => pose.name === name);
  const pose = poses[place];
  if (!pose) return [poses, name];
  const copy = freshName(poses, name);
  return [poses.toSpliced(place + 1, 0, { ...pose, name: copy }), copy];
}

/** One place earlier (-1) or later (1). */
export function moved(poses: Poses, name: string, by: -1 | 1): Poses {
  const place = poses.findIndex((pose) => pose.name === name);
  const other = place + by;
  if (place < 0 || other < 0 || other >= poses.length) return poses;
  return poses.with(place, poses[other]!).with(other, poses[place]!);
}

/** With others behind: those that are there already stay, and those whose name is get another. */
export function added(poses: Poses, others: Poses): Poses {
  const all = new Map(poses.map((pose) => [pose.name, pose]));
  for (const pose of others) {
    const same = all.get(pose.name);
    if (same && equalWeights(same.weights, pose.weights)) continue;
    const name = nameBeside(all, pose.name);
    all.set(name, { ...pose, name });
  }
  return [...all.values()];
}

export function equalWeights(one: Weights, other: Weights): boolean {
  const names = Object.keys(one);
  return (
    names.length === Object.keys(other).length && names.every((name) => one[name] === other[name])
  );
}

// Sliders move in hundredths, performances in single precision: more digits say nothing.
function rounded(weights: Weights): Weights {
  const short = ([name, weight]: [string, number]) => [name, Number(weight.toFixed(6))] as const;
  return Object.fromEntries(Object.entries(weights).map(short));
}
