// Run by test_js_runtime.py, in a process of its own, for which one kind of array is compiled.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { setTimeout } from 'node:timers/promises';
import { Bender, Follower } from '../../runtimes/js/index.js';

const kit = new URL('../../runtimes/conformance/vectors/', import.meta.url);
const { extras } = JSON.parse(readFileSync(new URL('folds.json', kit)));

test('frames allocate nothing', async () => {
  const follower = new Follower(new Bender(extras));
  const weights = extras.targetNames.map(() => 0.5); // as in three.js
  const frames = (count) => {
    for (let i = 0; i < count; i += 1) {
      weights[0] = (i % 100) / 100;
      weights[1] = (i % 7) / 7;
      follower.follow(weights);
    }
  };
  frames(100_000); // until it is compiled
  let collections = 0;
  const observer = new PerformanceObserver((list) => (collections += list.getEntries().length));
  observer.observe({ entryTypes: ['gc'] });
  frames(2_000_000);
  await setTimeout(20);
  observer.disconnect();
  assert.ok(collections < 2, `${collections}`); // one number a frame would ask for two and more
});
