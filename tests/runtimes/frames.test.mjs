// Run by test_js_runtime.py with the name of a vector, in a process of its own, for which one kind of
// array is compiled.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { constants } from 'node:perf_hooks';
import { test } from 'node:test';
import { setTimeout } from 'node:timers/promises';
import { Bender, Follower } from '../../runtimes/js/index.js';

const kit = new URL('../../runtimes/conformance/vectors/', import.meta.url);
const { extras } = JSON.parse(readFileSync(new URL(`${process.argv[2]}.json`, kit)));

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
  // Until the machine's code is made, which another core does in its own time, results of calls are
  // stored; code that stores one a frame does so in every round.
  let collections = Infinity;
  for (let round = 0; round < 12 && collections > 1; round += 1) {
    collections = 0;
    const observer = new PerformanceObserver((list) => {
      // Of what was made lately: all of the memory is looked at now and then, whatever is made.
      const young = ({ detail }) => detail.kind === constants.NODE_PERFORMANCE_GC_MINOR;
      collections += list.getEntries().filter(young).length;
    });
    observer.observe({ entryTypes: ['gc'] });
    frames(Math.min(2_000_000, 20_000_000 / follower.bender.morphs.length));
    await setTimeout(20);
    observer.disconnect();
  }
  assert.ok(collections < 2, `${collections}`); // one number a frame would ask for two and more
});
