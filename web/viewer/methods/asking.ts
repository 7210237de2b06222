// Asks the command that shows this page for something, and hears what it is doing meanwhile.
import { isEntry, type Entry } from '../files/document';

const GONE =
  'No answer: the command that showed this page has ended. Start it again and open the address it prints.';

/**
 * What a service answers.
 *
 * @param says hears what is being done
 * @throws Error with a sentence for people; an AbortError where nobody wants to know any more
 */
export async function ask(
  address: string,
  question: BodyInit,
  says: (words: string) => void,
  signal?: AbortSignal,
): Promise<Entry> {
  const post = { method: 'POST', body: question, ...(signal && { signal }) };
  const reply = await fetch(address, post).catch(gone);
  if (!reply.ok || !reply.body) {
    throw new Error(
      reply.status === 413 ? 'That is more than the command takes at once.' : GONE,
    );
  }
  const reader = reply.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = '';
  for (;;) {
    const { value, done } = await reader.read().catch(gone);
    if (done) throw new Error(GONE);
    const lines = (text + value).split('\n');
    text = lines.pop() ?? '';
    for (const line of lines) {
      const told: unknown = JSON.parse(line);
      if (!isEntry(told)) continue;
      if (typeof told['says'] === 'string') says(told['says']);
      if (typeof told['problem'] === 'string') throw new Error(told['problem']);
      if (isEntry(told['done'])) return told['done'];
    }
  }
}

/** The bytes of a model that a service has put beside the page. */
export async function modelBytes(address: string, signal?: AbortSignal): Promise<ArrayBuffer> {
  const reply = await fetch(address, signal ? { signal } : {}).catch(gone);
  if (!reply.ok) throw new Error(GONE);
  return reply.arrayBuffer();
}

export function isAborted(error: unknown): boolean {
  return error instanceof DOMException && error.name === 'AbortError';
}

function gone(error: unknown): never {
  throw isAborted(error) ? error : new Error(GONE);
}
