// From sliders to the weights of morph targets, as `extras.elastomorph` of a glTF mesh says.

const NEWEST = 3;
const MOST_TERMS = 256;

/** The weights of one mesh: made once, asked in every frame. */
export class Bender {
  /**
   * @param extras of a glTF mesh
   * @param targets names of its morph targets in order
   * @throws Error where the extras do not fit
   */
  constructor(extras, targets = extras.targetNames ?? []) {
    const { version, morphs, correctives } = described(extras);
    const free = new Set(targets.keys());
    const take = ({ target: name, index }) => {
      const first = targets.indexOf(name);
      const told = version > 2 && targets[index] === name;
      demand(
        free.delete(told ? index : first) && (told || first === targets.lastIndexOf(name)),
        `morph target '${name}' is missing or used twice`,
      );
      return told ? index : first;
    };
    const all = list(morphs).map((morph) => ({
      name: morph.name,
      target: take(morph),
      fold: version > 1 && morph.fold !== undefined ? curve(morph.fold) : null,
      bends: list(morph.bends).map((bend) => ({ target: take(bend), curve: curve(bend.curve) })),
    }));
    for (const target of free) all.push({ name: targets[target], target, fold: null, bends: [] });
    const names = all.map(({ name }) => name);
    demand(
      names.every((name) => typeof name === 'string') && new Set(names).size === names.length,
      'a name is no text, or given twice',
    );
    const drivers = driversOf(list(correctives), new Set(names));
    /** Names of the morph targets, in the order of their weights. */
    this.targets = targets;
    const own = all.filter(({ name }) => drivers.get(name)?.includes(name) ?? true);
    /** Names of the sliders, in the order of their values. */
    this.sliders = own.map(({ name }) => name);
    /** For each slider, the number of the morph target where programs without this one set it. */
    this.sliderTargets = own.map(({ target }) => target);
    const column = new Map(this.sliders.map((name, i) => [name, i]));
    /** Each path: numbers of its targets, curves of their weights, and its sliders. */
    this.morphs = all.map((morph) => ({
      ...morph,
      drivers: (drivers.get(morph.name) ?? [morph.name]).map((name) => column.get(name)),
    }));
  }

  /** The values of the sliders in order; one that is not named is 0. */
  values(sliders) {
    return this.sliders.map((name) => valueOf(sliders, name));
  }

  /** Writes the weight of each morph target into `out`, from the values of the sliders in order. */
  weights(values, out = new Float64Array(this.targets.length)) {
    for (let m = 0; m < this.morphs.length; m += 1) {
      const { target, fold, bends, drivers } = this.morphs[m];
      let t = 1;
      for (let d = 0; d < drivers.length; d += 1) {
        const value = values[drivers[d]];
        t *= Number.isFinite(value) ? value : 0;
      }
      out[target] = fold ? t + fold(t) : t;
      for (let k = 0; k < bends.length; k += 1) out[bends[k].target] = bends[k].curve(t);
    }
    return out;
  }
}

/**
 * The extras of a mesh in a file of curves: by its name, that of its node, its number, or the names
 * of its targets. Undefined where there is none, or several have the name.
 */
export function curvesOf({ version, meshes }, mesh) {
  const found = meshes.filter((own) =>
    Array.isArray(mesh)
      ? mesh.length === own.targetNames.length && mesh.every((n, i) => n === own.targetNames[i])
      : mesh === undefined || own.names.includes(mesh) || String(own.mesh) === String(mesh),
  );
  return version === 1 && (found.length === 1 || Array.isArray(mesh)) ? found[0] : undefined;
}

const made = new WeakMap();

/** What was made for a key before; null where it cannot be made, which is said the first time. */
function once(key, make) {
  if (!made.has(key)) {
    made.set(key, null);
    try {
      made.set(key, make());
    } catch (error) {
      console.warn(key.name ?? '', error.message);
    }
  }
  return made.get(key);
}

/**
 * The weight of each morph target of a mesh, in the order of `targetNames`: where its extras do not
 * fit, that of the slider of its name.
 */
export function bendWeights(extras, sliders) {
  const bender = once(extras, () => new Bender(extras));
  if (bender) return bender.weights(bender.values(sliders));
  return Float64Array.from(extras.targetNames ?? [], (name) => valueOf(sliders, name));
}

// A weight of 0 that a slider was turned to by others: not told from 0 by any renderer.
const ALMOST = 1e-45;

/**
 * Reads the sliders where players set them, as weights of their morph targets, and writes the
 * weights of all. Twice is as once: a weight that still is what was written says nothing new.
 */
export class Follower {
  #values;
  #written;

  constructor(bender) {
    this.bender = bender;
    this.influences = bender.targets.map(() => 0);
    this.#values = bender.values({});
    this.#written = this.influences.map(() => NaN);
  }

  /** The one of a mesh, made where there is none; null where its extras do not fit. */
  static of(mesh, extras, targets) {
    return once(mesh, () => new Follower(new Bender(extras, targets())));
  }

  follow(influences = this.influences) {
    const { sliderTargets } = this.bender;
    const values = this.#values;
    const written = this.#written;
    for (let i = 0; i < values.length; i += 1) {
      const now = influences[sliderTargets[i]];
      if (now !== written[sliderTargets[i]]) values[i] = now;
    }
    this.bender.weights(values, influences);
    for (let i = 0; i < values.length; i += 1)
      if (values[i]) influences[sliderTargets[i]] ||= ALMOST;
    for (let i = 0; i < written.length; i += 1) written[i] = influences[i];
  }
}

function described(extras) {
  const stored = extras.elastomorph ?? { version: 1 };
  const { version } = stored;
  demand(Number.isInteger(version) && version > 0, 'no version');
  demand(version <= NEWEST, `version ${version} needs a newer elastomorph`);
  return stored;
}

/** Name and drivers of each corrective. */
function driversOf(correctives, names) {
  const drivers = new Map();
  for (const { name, drivers: own } of correctives) {
    demand(
      names.has(name) && !drivers.has(name),
      `corrective '${name}' is no morph, or given twice`,
    );
    demand(
      Array.isArray(own) && own.length > 0 && own.every((driver) => names.has(driver)),
      `drivers of '${name}' are no morphs`,
    );
    drivers.set(name, own);
  }
  for (const [name, own] of drivers)
    for (const driver of own)
      demand(driver === name || !drivers.has(driver), `driver '${driver}' is a corrective`);
  return drivers;
}

/** t → b(t): a piecewise polynomial between 0 and 1, straight on along its ends beyond them. */
function curve(stored) {
  const breaks = stored?.breaks;
  const rows = stored?.coefficients;
  const last = rows?.length - 1;
  demand(
    numbers(breaks) &&
      breaks.length === last + 2 &&
      last >= 0 &&
      breaks[0] === 0 &&
      breaks[last + 1] === 1 &&
      breaks.every((time, i) => i === 0 || time > breaks[i - 1]) &&
      rows.every((row) => numbers(row) && row.length === rows[0].length) &&
      rows[0].length > 0 &&
      rows[0].length <= MOST_TERMS,
    'a curve is damaged',
  );
  const width = 1 - breaks[last];
  const scale = rows.flat().reduce((most, a) => Math.max(most, Math.abs(a)), 1);
  const ends = Math.max(Math.abs(rows[0][0]), Math.abs(value(rows[last], width)));
  demand(ends <= 1e-9 * scale, 'a curve is not 0 at its ends');
  const first = rows[0][1] ?? 0;
  const end = value(
    rows[last].map((a, n) => n * a).slice(1),
    width,
  );
  return Object.assign(at, stored);
  function at(t) {
    if (t <= 0) return first * t;
    if (t >= 1) return end * (t - 1);
    let low = 0;
    let high = last;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (breaks[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return value(rows[low], t - breaks[low]);
  }
}

function value(row, s) {
  let sum = 0;
  for (let n = row.length - 1; n >= 0; n -= 1) sum = sum * s + row[n];
  return sum;
}

function numbers(row) {
  return Array.isArray(row) && row.every(Number.isFinite);
}

/** A list of objects; an empty one may have been left out. */
function list(entries = []) {
  demand(
    Array.isArray(entries) && entries.every((entry) => entry && typeof entry === 'object'),
    'no list of objects',
  );
  return entries;
}

function valueOf(sliders, name) {
  return Object.hasOwn(sliders, name) ? sliders[name] : 0;
}

function demand(holds, otherwise) {
  if (!holds) throw new Error(`extras.elastomorph: ${otherwise}`);
}
