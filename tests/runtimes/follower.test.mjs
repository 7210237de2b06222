// Run by test_js_runtime.py: what the adapters for engines rely on.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Bender, bendWeights, curvesOf, Follower } from '../../runtimes/js/index.js';
import { keepExtras, bendMesh as bendBabylon } from '../../runtimes/js/babylon.js';
import { addCurves, bendMesh } from '../../runtimes/js/three.js';

const bump = { breaks: [0, 1], coefficients: [[0, 1, -1]] };
const extras = {
  targetNames: ['jawOpen', 'close', 'brow', 'jawOpen.bend1', 'close.bend1'],
  elastomorph: {
    version: 2,
    morphs: [
      { name: 'jawOpen', target: 'jawOpen', fold: bump, bends: [{ target: 'jawOpen.bend1', curve: bump }] },
      { name: 'close', target: 'close', bends: [{ target: 'close.bend1', curve: bump }] },
      { name: 'brow', target: 'brow' },
    ],
    correctives: [{ name: 'close', drivers: ['jawOpen', 'close'] }],
  },
};
const JAW = 0, CLOSE = 1;
const expected = (jawOpen, close, brow = 0) => [...bendWeights(extras, { jawOpen, close, brow })];

for (const Numbers of [Array, Float64Array, Float32Array]) {
  const near = (found, wanted) =>
    found.forEach((weight, i) => assert.ok(Math.abs(weight - wanted[i]) < 1e-6, `${found} ${wanted}`));

  test(`twice is as once: ${Numbers.name}`, () => {
    const follower = new Follower(new Bender(extras));
    const weights = Numbers.from([0.5, 0.25, 1, 7, 7]);
    for (let frame = 0; frame < 5; frame += 1) {
      follower.follow(weights);
      near(weights, expected(0.5, 0.25, 1));
    }
  });

  test(`a slider may be set to where its weight is: ${Numbers.name}`, () => {
    const follower = new Follower(new Bender(extras));
    const weights = Numbers.from([0, 0.25, 0, 0, 0]);
    follower.follow(weights);
    near(weights, expected(0, 0));
    weights[JAW] = 1; // the corrective is still where it was turned to
    follower.follow(weights);
    near(weights, expected(1, 0.25));
    weights[JAW] = 0;
    follower.follow(weights);
    weights[CLOSE] = 0; // where its weight is already
    follower.follow(weights);
    weights[JAW] = 1;
    follower.follow(weights);
    near(weights, expected(1, 0));
  });

  test(`players that set all sliders in every frame: ${Numbers.name}`, () => {
    const follower = new Follower(new Bender(extras));
    const weights = new Numbers(5).fill(0);
    for (let i = 0; i <= 20; i += 1) {
      const jaw = i / 20;
      const close = (i % 7) / 7;
      weights[JAW] = jaw;
      weights[CLOSE] = close;
      weights[2] = 1 - jaw;
      follower.follow(weights);
      near(weights, expected(jaw, close, 1 - jaw));
    }
  });
}

test('weights that are no numbers are 0', () => {
  for (const value of [NaN, Infinity, -Infinity, undefined])
    assert.deepEqual(expected(value, 1), expected(0, 1));
});

test('weights are written where they have a place', () => {
  const bender = new Bender(extras);
  const out = new Float32Array(5);
  assert.equal(bender.weights([0.5, 0, 0], out), out);
  assert.deepEqual([...bendWeights(extras, { jawOpen: 0.5 })], [...out]);
});

test('what has no bends is left alone', () => {
  const light = { userData: {} };
  bendMesh(light);
  const mesh = { userData: {}, morphTargetInfluences: [0.5], morphTargetDictionary: { a: 0 } };
  bendMesh(mesh);
  assert.deepEqual(mesh.morphTargetInfluences, [0.5]);
  bendBabylon({ metadata: null, morphTargetManager: null });
  bendBabylon({ metadata: null, morphTargetManager: { numTargets: 1 } });
  const loader = { gltf: { meshes: [{}] } };
  assert.equal(keepExtras(loader).loadNodeAsync('/nodes/0', { mesh: 0 }, () => {}), null);
  assert.equal(keepExtras(loader).loadNodeAsync('/nodes/0', {}, () => {}), null);
});

test('targets are in the order of the engine, whatever their names', () => {
  const names = ['10', '2', 'a'];
  const numbered = {
    elastomorph: { version: 1, morphs: [{ name: 's', target: '10', bends: [{ target: '2', curve: bump }] }] },
  };
  const mesh = {
    userData: numbered,
    morphTargetDictionary: Object.fromEntries(names.map((name, i) => [name, i])),
    morphTargetInfluences: [0.5, 0, 0.75],
  };
  bendMesh(mesh);
  assert.deepEqual(mesh.morphTargetInfluences, [0.5, 0.25, 0.75]);
});

test('a mesh whose extras do not fit is left alone, and said to be so once', (t) => {
  const warn = t.mock.method(console, 'warn', () => {});
  const mesh = {
    name: 'face',
    userData: extras,
    morphTargetDictionary: { other: 0 },
    morphTargetInfluences: [0.5],
  };
  const targets = { numTargets: 1, getTarget: () => ({ name: 'other', influence: 0.5 }) };
  const other = { name: 'babylon', metadata: extras, morphTargetManager: targets };
  for (let frame = 0; frame < 3; frame += 1) {
    bendMesh(mesh);
    bendBabylon(other);
  }
  assert.deepEqual(mesh.morphTargetInfluences, [0.5]);
  const said = warn.mock.calls.map((call) => call.arguments.join(' '));
  assert.equal(said.length, 2);
  for (const [i, name] of ['face', 'babylon'].entries())
    assert.match(said[i], new RegExp(`^${name} .*morph target 'jawOpen' is missing`));
});

test('weights by extras that do not fit are those of the sliders, said to be so once', (t) => {
  const warn = t.mock.method(console, 'warn', () => {});
  const damaged = { targetNames: ['a', 'b', 'a'], elastomorph: { version: 1, morphs: 7 } };
  for (let frame = 0; frame < 3; frame += 1)
    assert.deepEqual([...bendWeights(damaged, { a: 0.5, c: 1 })], [0.5, 0, 0.5]);
  assert.equal(warn.mock.callCount(), 1);
});

test('targets that share a name are told by their numbers', () => {
  const morphs = [1, 0].map((index) => ({ name: `open ${index}`, target: 'open', index, bends: [] }));
  morphs[1].bends.push({ target: 'open.bend1', index: 9, curve: bump }); // moved: known by its name
  const elastomorph = { version: 3, morphs };
  const userData = { targetNames: ['open', 'open', 'open.bend1'], elastomorph };
  const mesh = {
    userData,
    morphTargetDictionary: { open: 1, 'open.bend1': 2 }, // as three.js makes it
    morphTargetInfluences: [0.5, 0.75, 0],
  };
  bendMesh(mesh);
  assert.deepEqual(mesh.morphTargetInfluences, [0.5, 0.75, 0.25]);
  assert.deepEqual(new Bender(userData).sliders, ['open 1', 'open 0']);
  const twice = { ...userData, elastomorph: { version: 3, morphs: [morphs[0], morphs[0]] } };
  const two = { ...userData, elastomorph: { version: 2, morphs } };
  for (const refused of [twice, two]) assert.throws(() => new Bender(refused), /missing or used twice/);
});

test('what several sliders drive is passed over by adapters that read sliders', () => {
  const morphs = [
    { name: 'a_b', bends: [{ target: 'a_b.bend1', curve: bump }] }, // no target: a pair bend
    { name: 'a', target: 'a' },
    { name: 'b', target: 'b' },
    { name: 'lid', target: 'lid' },
  ];
  const correctives = [
    { name: 'a_b', drivers: ['a', 'b'], law: 'min' },
    { name: 'lid', drivers: ['b', 'a'], law: 'hinge', gains: [0.5, 1] },
  ];
  const targetNames = ['a', 'b', 'lid', 'a_b.bend1'];
  const described = { targetNames, elastomorph: { version: 3, morphs, correctives } };
  const bender = new Bender(described);
  assert.deepEqual([bender.sliders, bender.sliderTargets], [['a', 'b'], [0, 1]]);
  assert.deepEqual([...bender.times([1, 0.5])], [0.5, 1, 0.5, 0.25]);
  const mesh = {
    userData: described,
    morphTargetDictionary: Object.fromEntries(targetNames.map((name, i) => [name, i])),
    morphTargetInfluences: [1, 0.5, 0, 0],
  };
  const targets = targetNames.map((name, i) => ({ name, influence: [1, 0.5, 0, 0][i] }));
  const manager = { numTargets: 4, getTarget: (i) => targets[i] };
  const other = { metadata: described, morphTargetManager: manager };
  for (let frame = 0; frame < 3; frame += 1) {
    bendMesh(mesh);
    bendBabylon(other);
  }
  const expected = [1, 0.5, 0.25, 0.25];
  assert.deepEqual(mesh.morphTargetInfluences, expected);
  assert.deepEqual(targets.map(({ influence }) => influence), expected);
  const earlier = { ...described.elastomorph, version: 2 };
  for (const stored of [earlier, { ...described.elastomorph, correctives: correctives.slice(1) }])
    assert.throws(() => new Bender({ targetNames, elastomorph: stored }), /missing|has no target/);
});

test('curves in a file beside are those of a mesh by name, number or targets', () => {
  const face = { mesh: 3, names: ['Face', 'head'], ...extras };
  const other = { mesh: 4, names: ['Face', '9'], targetNames: ['a'], elastomorph: { version: 1 } };
  const curves = { version: 1, meshes: [other, face] };
  for (const mesh of ['head', 3, '3', extras.targetNames]) assert.equal(curvesOf(curves, mesh), face);
  for (const mesh of ['Face', 'none', 5, undefined, ['a', 'b']])
    assert.equal(curvesOf(curves, mesh), undefined);
  assert.equal(curvesOf({ version: 1, meshes: [face] }), face);
  assert.equal(curvesOf({ version: 2, meshes: [face] }), undefined);
  const numbers = Object.fromEntries(extras.targetNames.map((name, i) => [name, i]));
  const mesh = { userData: {}, morphTargetDictionary: numbers, morphTargetInfluences: [0.5, 0, 0, 0, 0] };
  const light = { userData: {} };
  const unknown = { userData: {}, morphTargetDictionary: { b: 0 }, morphTargetInfluences: [0.5] };
  addCurves({ traverse: (visit) => [light, mesh, unknown].forEach(visit) }, curves);
  [light, mesh, unknown].forEach(bendMesh);
  assert.deepEqual(mesh.morphTargetInfluences, expected(0.5, 0));
  assert.deepEqual(unknown, { ...unknown, userData: {}, morphTargetInfluences: [0.5] });
});
