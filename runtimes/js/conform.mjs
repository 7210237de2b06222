// Answers a file of the conformance kit: `node conform.mjs ../conformance/vectors/folds.json`.
import { readFileSync } from 'node:fs';
import { Bender, bendWeights, curvesOf } from './index.js';

function refusal({ extras }) {
  try {
    new Bender(extras);
    return null;
  } catch (error) {
    return error.message;
  }
}

function weights({ extras: own, curves, mesh, poses }) {
  const extras = curves ? curvesOf(curves, mesh) : own;
  const bender = new Bender(extras);
  return poses.map(({ sliders }) => {
    const values = bender.sliders.map((name) => (Object.hasOwn(sliders, name) ? sliders[name] : NaN));
    return {
      double: [...bendWeights(extras, sliders)],
      single: [...bender.weights(values, new Float32Array(bender.targets.length))],
    };
  });
}

const content = JSON.parse(readFileSync(process.argv[2], 'utf8'));
console.log(JSON.stringify(Array.isArray(content) ? content.map(refusal) : weights(content)));
