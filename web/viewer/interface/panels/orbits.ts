// The vertices whose ways are drawn as t runs from 0 to 1.
import { toggle } from '../parts/controls';
import { element, freshId, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { Context, Part } from '../parts/part';
import { picking } from '../state/picking';

export function createOrbits({ store, stage, scene }: Context): Part {
  const orbits = toggle(store, 'orbits', 'Draw orbits', 'O');
  const hint = element('p', { class: 'hint' });
  const id = freshId('vertex');
  const number = element('input', { type: 'number', id, min: 0, step: 1, placeholder: '0' });
  const add = element('form', { class: 'add-vertex' });
  const worst = element('button', { type: 'button' }, 'Worst');
  const clear = element('button', { type: 'button' }, 'Clear');
  const list = element('ul', { class: 'picked', 'aria-label': 'Picked vertices' });
  let drawn: readonly number[] | null = null;

  add.append(
    element('label', { for: id }, 'Vertex'),
    number,
    element('button', { type: 'submit' }, 'Add'),
    worst,
    clear,
  );
  worst.title = 'The vertex farthest from the model compared against';
  add.addEventListener('submit', (event) => {
    event.preventDefault();
    const vertex = number.valueAsNumber;
    if (!Number.isInteger(vertex)) return;
    store.update(picking(store.get(), vertex) ?? {});
    number.value = '';
  });
  worst.addEventListener('click', () => {
    const vertex = stage.readout().heat?.worstVertex;
    if (vertex !== undefined) store.update(picking(store.get(), vertex) ?? {});
  });
  clear.addEventListener('click', () => {
    store.update({ picked: [] });
    number.focus();
  });

  const item = (vertex: number) => {
    const remove = element('button', { type: 'button', 'aria-label': `Remove vertex ${vertex}` });
    remove.append(icon('close'));
    remove.addEventListener('click', () => {
      const at = store.get().picked.indexOf(vertex);
      store.update({ picked: store.get().picked.filter((other) => other !== vertex) });
      requestAnimationFrame(() => {
        const left = list.querySelectorAll('button');
        (left[Math.min(at, left.length - 1)] ?? number).focus();
      });
    });
    return element('li', {}, String(vertex), remove);
  };

  return {
    element: element(
      'section',
      { class: 'block' },
      element('h2', {}, 'Orbits'),
      orbits.element,
      hint,
      add,
      list,
    ),
    show(state) {
      const vertices = (scene()?.models[0]?.neutral.length ?? 0) / 3;
      orbits.show(state);
      number.max = String(Math.max(0, vertices - 1));
      worst.hidden = !state.heat;
      clear.disabled = state.picked.length === 0;
      setText(
        hint,
        state.picked.length === 0
          ? 'Click the face or type a number to pick vertices. Their ways are drawn for t from 0 to 1.'
          : 'Click a picked vertex again to remove it.',
      );
      if (state.picked === drawn) return;
      drawn = state.picked;
      list.replaceChildren(...state.picked.map(item));
    },
  };
}
