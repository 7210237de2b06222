// The panel: its tabs, and whether it is open.
import { element, freshId, setAttribute } from '../../../shared/element';

export interface Tab {
  readonly name: string;
  readonly content: HTMLElement;
}

export interface Tabs {
  readonly element: HTMLElement;
  select(name: string): void;
  open(open: boolean): void;
  isOpen(): boolean;
}

/** @param opened hears that the panel opens or closes. */
export function createTabs(tabs: readonly Tab[], opened: (open: boolean) => void): Tabs {
  const buttons = tabs.map(({ name }) =>
    element('button', { type: 'button', role: 'tab', id: freshId('tab') }, name),
  );
  const bodies = tabs.map(({ content }, i) =>
    element(
      'div',
      { role: 'tabpanel', id: freshId('panel'), 'aria-labelledby': buttons[i]?.id ?? '' },
      content,
    ),
  );
  const strip = element('div', { role: 'tablist', 'aria-label': 'Panel' }, ...buttons);
  const whole = element('aside', { class: 'panel', 'aria-label': 'Settings' }, strip, ...bodies);
  let selected = 0;
  let isOpen = true;

  const show = () => {
    buttons.forEach((button, i) => {
      setAttribute(button, 'aria-selected', String(i === selected));
      setAttribute(button, 'aria-controls', bodies[i]?.id ?? '');
      button.tabIndex = i === selected ? 0 : -1;
    });
    bodies.forEach((body, i) => {
      body.hidden = !isOpen || i !== selected;
    });
    setAttribute(whole, 'data-open', isOpen);
    opened(isOpen);
  };
  const select = (place: number) => {
    selected = (place + tabs.length) % tabs.length;
    isOpen = true;
    show();
  };

  buttons.forEach((button, i) => {
    button.addEventListener('click', () => {
      // As a sheet at the bottom the strip stays in sight: its own tab closes it.
      const closes = isOpen && i === selected && matchMedia('(max-width: 720px)').matches;
      if (closes) {
        isOpen = false;
        show();
      } else select(i);
    });
  });
  strip.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    select(selected + step);
    buttons[selected]?.focus();
  });
  show();

  return {
    element: whole,
    select: (name) => select(Math.max(0, tabs.findIndex((tab) => tab.name === name))),
    open(open) {
      isOpen = open;
      show();
    },
    isOpen: () => isOpen,
  };
}
