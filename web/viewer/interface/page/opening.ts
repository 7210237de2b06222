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
  /** The hidden field behind the buttons, to be put on the page. */
  readonly element: HTMLElement;
  ask(): void;
}

export interface Teller {
  tell(message: string): void;
  busy(words: string | null): void;
}

export function createOpening(openers: readonly Opener[], teller: Teller): Opening {
  const field = element('input', {
    type: 'file',
    accept: openers.map(({ accepts }) => accepts).join(),
    multiple: true,
    hidden: true,
    'aria-label': 'Files to open',
  });
  const open = (files: readonly File[]) => void openAll(files, openers, teller);
  field.addEventListener('change', () => {
    open([...(field.files ?? [])]);
    field.value = ''; // so that the same file can be opened again
  });
  takeDrops(open);
  return { element: field, ask: () => field.click() };
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
    take([...(event.dataTransfer?.files ?? [])]);
  });
}
