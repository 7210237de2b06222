// How a page begins, and what it says where it cannot.

/** Starts the page in its element; a page that cannot be shown says why and is not left empty. */
export function begin(start: (root: HTMLElement) => void): void {
  const root = document.querySelector('main')!;
  try {
    start(root);
  } catch (error) {
    const words = document.createElement('p');
    words.setAttribute('role', 'alert');
    words.className = 'cannot';
    words.textContent = wordsOf(error);
    root.replaceChildren(words);
  }
}

/** What went wrong, as a sentence for people. */
export function wordsOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}
