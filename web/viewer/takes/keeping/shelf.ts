// The browser's database of takes. Every curve is an entry of its own, so that an edit writes no more
// than what it changed.

const [DATABASE, STORE] = ['elastomorph', 'takes'];
const LONGEST = 15_000; // milliseconds that a page waits for what the browser has

/** Rig, take, and what of it: one of PARTS or after them, or the name of a slider for its curve. */
export type Key = [rig: string, take: string, part: number | string];

/** What there is of a take beside its curves; from `weights` on those of its file, in pieces. */
export const PARTS = { head: 0, base: 1, sound: 2, weights: 3 } as const;

/**
 * Does something with the entries: all of it, or nothing.
 *
 * @throws DOMException where the browser has no room, forbids it or cannot read what it has, and
 *     nothing where it does not answer
 */
export async function atShelf<T>(
  mode: IDBTransactionMode,
  run: (entries: IDBObjectStore) => Promise<T>,
): Promise<T> {
  const opening = indexedDB.open(DATABASE, 1);
  opening.onupgradeneeded = () => opening.result.createObjectStore(STORE);
  const connecting = answer(opening);
  const database = await inTime(connecting).catch((problem: unknown) => {
    connecting.then((late) => late.close()).catch(() => undefined);
    throw problem;
  });
  try {
    const transaction = database.transaction(STORE, mode);
    const over = new Promise<void>((resolve, reject) => {
      transaction.oncomplete = () => resolve();
      transaction.onabort = () => reject(transaction.error);
    });
    const doing = run(transaction.objectStore(STORE)).catch((problem: unknown) => {
      over.catch(() => undefined); // it ends for the reason that is known
      transaction.abort();
      throw problem;
    });
    const [found] = await Promise.all([doing, over]);
    return found;
  } finally {
    database.close();
  }
}

/** What the database answers to one request. */
export function answer<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = (event) => {
      event.preventDefault(); // whoever asked ends the transaction
      reject(request.error);
    };
  });
}

/** Rejects where a browser does not answer. */
export function inTime<T>(promise: Promise<T>): Promise<T> {
  const late = new Promise<never>((_, reject) => setTimeout(reject, LONGEST));
  return Promise.race([promise, late]);
}

/** Everything that begins so: of a rig, or of a take. */
export function within(...start: string[]): IDBKeyRange {
  return IDBKeyRange.bound(start, [...start, []]); // lists come after all else
}

/** The pieces of a take's weights, or with its curves, which come after them. */
export function numbers(rig: string, take: string, curves: boolean): IDBKeyRange {
  return IDBKeyRange.bound([rig, take, PARTS.weights], [rig, take, curves ? [] : '']);
}
