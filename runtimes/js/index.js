// From sliders to the weights of morph targets, as `extras.elastomorph` of a glTF mesh says.

const NEWEST = 3;
const MOST_TERMS = 256;
const SIMPLEX = ['allMul', 'extMul', 'mulAvgExt', 'mulAvgAll']; // of drivers up to 1
const LAWS = ['product', 'min', 'softmin', 'hinge', ...SIMPLEX];

/** The weights of one mesh: made once, asked in every frame. */
export class Bender {
  #times;

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
      target: version > 2 && morph.target === undefined ? null : take(morph),
      fold: version > 1 && morph.fold !== undefined ? curve(morph.fold) : null,
      bends: list(morph.bends).map((bend) => ({ target: take(bend), curve: curve(bend.curve) })),
    }));
    for (const target of free) all.push({ name: targets[target], target, fold: null, bends: [] });
    const names = all.map(({ name }) => name);
    demand(
      names.every((name) => typeof name === 'string') && new Set(names).size === names.length,
      'a name is no text, or given twice',
    );
    const driven = drivenBy(list(correctives), new Set(names), version);
    /** Names of the morph targets, in the order of their weights. */
    this.targets = targets;
    const own = all.filter(({ name }) => driven.get(name)?.drivers.includes(name) ?? true);
    /** Names of the sliders, in the order of their values. */
    this.sliders = own.map(({ name }) => name);
    /** For each slider, the number of the morph target where programs without this one set it. */
    this.sliderTargets = own.map(({ target }) => target);
    demand(!this.sliderTargets.includes(null), 'a slider has no target');
    const column = new Map(this.sliders.map((name, i) => [name, i]));
    /** Each path: numbers of its targets, curves of their weights, its sliders and their law. */
    this.morphs = all.map((morph) => {
      const { drivers, ...law } = driven.get(morph.name) ?? { drivers: [morph.name], law: 'product' };
      return { ...morph, ...law, drivers: drivers.map((name) => column.get(name)) };
    });
    this.#times = this.times([]);
  }

  /** The values of the sliders in order; one that is not named is 0. */
  values(sliders) {
    return this.sliders.map((name) => valueOf(sliders, name));
  }

  /** Writes the time of each path into `out`, from the values of the sliders in order. */
  times(values, out = new Float64Array(this.morphs.length)) {
    for (let m = 0; m < this.morphs.length; m += 1) {
      const { drivers, law, gains, sharpness } = this.morphs[m];
      const count = drivers.length;
      let t = 1; // product and allMul, until another law says otherwise
      let sum = 0;
      let low = Infinity;
      let high = 0;
      for (let d = 0; d < count; d += 1) {
        let w = values[drivers[d]];
        if (!Number.isFinite(w)) w = 0;
        if (w > 1 && SIMPLEX.includes(law)) w = 1;
        t *= w;
        sum += gains ? gains[d] * w : w;
        if (w < low) low = w;
        if (w > high) high = w;
      }
      let mean = 0; // of powers relative to the least, so that none overflows
      if (sharpness)
        for (let d = 0; d < count; d += 1) mean += (low / values[drivers[d]]) ** sharpness[0] / count;
      if (gains) t = sum > 1 ? sum - 1 : 0;
      else if (low <= 0 && law !== 'product') t = 0;
      else if (sharpness) t = low * mean ** (-1 / sharpness[0]);
      else if (law === 'min') t = low;
      else if (law === 'extMul') t = low * high;
      else if (law === 'mulAvgExt') t = (2 * low * high) / (low + high);
      else if (law === 'mulAvgAll') t *= count / sum;
      out[m] = t;
    }
    return out;
  }

  /** Writes the weight of each morph target into `out`, from the values of the sliders in order. */
  weights(values, out = new Float64Array(this.targets.length)) {
    const times = this.times(values, this.#times);
    for (let m = 0; m < times.length; m += 1) {
      const { target, fold, bends } = this.morphs[m];
      const t = times[m];
      if (target !== null) out[target] = fold ? t + fold(t) : t;
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

/** Of each corrective by its name, drivers and their law. */
function drivenBy(correctives, names, version) {
  const driven = new Map();
  for (const { name, drivers, ...own } of correctives) {
    demand(names.has(name) && !driven.has(name), `corrective '${name}' is no morph, or given twice`);
    demand(
      Array.isArray(drivers) && drivers.length > 0 && drivers.every((driver) => names.has(driver)),
      `drivers of '${name}' are no morphs`,
    );
    const { law = 'product', gains, sharpness } = version > 2 ? own : {};
    demand(
      LAWS.includes(law) &&
        (law === 'hinge' ? numbers(gains) && gains.length === drivers.length : gains === undefined) &&
        (law === 'softmin' ? Number.isFinite(sharpness) && sharpness > 0 : sharpness === undefined),
      `law '${law}' does not fit`,
    );
    // In a list: a number of an object would be made anew in each frame.
    driven.set(name, { drivers, law, gains, sharpness: sharpness && [sharpness] });
  }
  for (const [name, { drivers }] of driven)
    for (const driver of drivers)
      demand(driver === name || !driven.has(driver), `driver '${driver}' is a corrective`);
  return driven;
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
