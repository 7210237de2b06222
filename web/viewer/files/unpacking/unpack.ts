// Unpacks in a worker, which is made of what the page holds compressed, and ended when it is done.
import { inflated } from '../packed';
import type { Answer, Job } from './jobs';

const SECONDS = 60; // of what takes a second where it is whole
const FORBIDDEN = 'it is compressed, and this browser does not let the page unpack it';

/** What a worker makes of a job; never longer than a minute. */
export async function unpack(job: Omit<Job, 'draco'>): Promise<Answer> {
  if (!('WebAssembly' in globalThis)) return { problem: FORBIDDEN };
  const [script, draco] = await Promise.all([
    import('./worker.ts?packed').then(({ default: text }) => inflated(text)),
    job.meshes.length > 0
      ? import('three/addons/libs/draco/gltf/draco_decoder.wasm?packed').then((held) =>
          inflated(held.default),
        )
      : null,
  ]);
  const address = URL.createObjectURL(new Blob([script], { type: 'text/javascript' }));
  const worker = new Worker(address);
  let limit: ReturnType<typeof setTimeout> | undefined;
  try {
    return await new Promise<Answer>((resolve) => {
      const fail = (problem: string) => resolve({ problem });
      limit = setTimeout(fail, 1000 * SECONDS, `unpacking it takes more than ${SECONDS} s: it is damaged`);
      worker.onmessage = ({ data }: MessageEvent<Answer>) => resolve(data);
      worker.onerror = (event) => {
        event.preventDefault();
        fail(FORBIDDEN);
      };
      worker.postMessage({ ...job, draco: draco?.buffer ?? null } satisfies Job);
    });
  } finally {
    clearTimeout(limit);
    worker.terminate();
    URL.revokeObjectURL(address);
  }
}
