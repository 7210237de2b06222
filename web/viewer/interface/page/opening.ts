// Files people open or drop: added to the models there are, or shown in their place.
import { openFile } from '../../files/open';
import type { Model, Scene } from '../../types/model';
import { element } from '../../../shared/element';
import { wordsOf } from '../../../shared/start';

export interface Opening {
  /** The hidden field behind the buttons, to be put on the page. */
  readonly element: HTMLElement;
  ask(): void;
}

export interface Receiver {
  scene(): Scene | null;
  /** Shows another scene; `added` are the numbers of its models that were not there before. */
  replace(scene: Scene, added: readonly number[]): void;
  tell(message: string): void;
  busy(words: string | null): void;
}

export function createOpening(receiver: Receiver): Opening {
  const field = element('input', {
    type: 'file',
    accept: '.glb,model/gltf-binary',
    multiple: true,
    hidden: true,
    'aria-label': 'Files to open',
  });
  field.addEventListener('change', () => {
    void openAll([...(field.files ?? [])], receiver);
    field.value = ''; // so that the same file can be opened again
  });
  takeDrops((files) => void openAll(files, receiver));
  return { element: field, ask: () => field.click() };
}

async function openAll(files: readonly File[], receiver: Receiver): Promise<void> {
  for (const file of files) {
    receiver.busy(`Opening ${file.name}…`);
    try {
      const model = await openFile(file.name, await file.arrayBuffer());
      const [scene, added] = joined(receiver.scene(), model);
      receiver.replace(scene, added);
    } catch (error) {
      receiver.tell(wordsOf(error));
    }
  }
  receiver.busy(null);
}

/** A model of as many vertices joins those there are; any other stands alone. */
export function joined(scene: Scene | null, model: Model): [Scene, number[]] {
  const fits = scene?.models[0]?.neutral.length === model.neutral.length;
  if (!scene || !fits) {
    return [{ title: model.name, unit: '', models: [model], start: {} }, [0]];
  }
  const same = scene.models.findIndex(({ name }) => name === model.name);
  const models = same < 0 ? [...scene.models, model] : scene.models.with(same, model);
  return [{ ...scene, models }, [same < 0 ? models.length - 1 : same]];
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
