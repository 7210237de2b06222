// Files people open or drop: each is offered to openers in turn, and those of a kind go together.
import { element } from '../../../shared/element';
import { wordsOf } from '../../../shared/start';

/** What opens files of some kind. */
export interface Opener {
  /** What the browser's own dialogue offers, such as '.csv,.npz'. */
  readonly accepts: string;
  /** Those of the files that it opens together, none for none; it is asked again for the rest. */
  fits(files: readonly File[]): readonly File[];
  /**
   * Opens what fits.
   *
   * @throws Error with a sentence for people
   */
  open(files: readonly File[]): Promise<void>;
}

export interface Opening {
  /** The hidden field behind the button, to be put on the page. */
  readonly element: HTMLElement;
  ask(): void;
  askForFolder(): void;
}

const paths = new WeakMap<File, string>(); // of those that were dropped in folders

/** The path of a file in the folder that was opened; its name where it was opened by itself. */
export function pathOf(file: File): string {
  return paths.get(file) ?? (file.webkitRelativePath || file.name);
}

const MOST_ENTRIES = 5000;

export interface Teller {
  tell(message: string): void;
  busy(words: string | null): void;
}

export function createOpening(openers: readonly Opener[], teller: Teller): Opening {
  const open = (files: readonly File[]) => void openAll(files, openers, teller);
  const field = (label: string, more: Record<string, string | boolean>) => {
    const made = element('input', { type: 'file', hidden: true, 'aria-label': label, ...more });
    made.addEventListener('change', () => {
      open([...(made.files ?? [])]);
      made.value = ''; // so that the same file can be opened again
    });
    return made;
  };
  const accept = openers.map(({ accepts }) => accepts).join();
  const files = field('Files to open', { accept, multiple: true });
  const folder = field('Folder to open', { webkitdirectory: true });
  takeDrops(open);
  return {
    element: files,
    ask: () => files.click(),
    askForFolder: () => folder.click(),
  };
}

async function openAll(files: readonly File[], openers: readonly Opener[], teller: Teller) {
  let left = files;
  for (const opener of openers) {
    for (let own = opener.fits(left); own.length > 0; own = opener.fits(left)) {
      const taken = own;
      left = left.filter((file) => !taken.includes(file));
      const others = taken.length > 1 ? ` and ${taken.length - 1} more` : '';
      teller.busy(`Opening ${taken[0]!.name}${others}…`);
      try {
        await opener.open(taken);
      } catch (error) {
        teller.tell(wordsOf(error));
      }
    }
  }
  teller.busy(null);
}

function takeDrops(take: (files: File[]) => void): void {
  const root = document.documentElement;
  const hasFiles = (event: DragEvent) => event.dataTransfer?.types.includes('Files') ?? false;
  addEventListener('dragover', (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    root.dataset.dropping = 'true';
  });
  addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) delete root.dataset.dropping;
  });
  addEventListener('drop', (event) => {
    delete root.dataset.dropping;
    if (!hasFiles(event)) return;
    event.preventDefault();
    // Both at once: after this event the browser hands out nothing more.
    const files = [...(event.dataTransfer?.files ?? [])];
    const entries = [...(event.dataTransfer?.items ?? [])].map((item) => item.webkitGetAsEntry());
    if (!entries.some((entry) => entry?.isDirectory)) take(files);
    else void Promise.all(entries.map(filesIn)).then((found) => take(found.flat()));
  });
}

/** The files in what was dropped, with their paths; what cannot be read is left out. */
async function filesIn(entry: FileSystemEntry | null): Promise<File[]> {
  if (entry?.isFile) {
    const file = await new Promise<File | null>((found) =>
      (entry as FileSystemFileEntry).file(found, () => found(null)),
    );
    if (file) paths.set(file, entry.fullPath.replace(/^\//, ''));
    return file ? [file] : [];
  }
  if (!entry?.isDirectory) return [];
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const inside: FileSystemEntry[] = [];
  // Browsers hand out a hundred at a time; more than anybody opens are not asked for.
  while (inside.length < MOST_ENTRIES) {
    const more = await new Promise<FileSystemEntry[]>((found) =>
      reader.readEntries(found, () => found([])),
    );
    if (more.length === 0) break;
    inside.push(...more);
  }
  return (await Promise.all(inside.map(filesIn))).flat();
}
