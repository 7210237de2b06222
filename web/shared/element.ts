// Makes elements of the page in one expression.

type Child = Node | string | null | undefined | false;
type Properties = Record<string, string | number | boolean | null | undefined | EventListener>;

/**
 * Attributes by name, event listeners by `on` and the event's name; `true` is an attribute without
 * a value, `false` and `null` leave it out.
 */
export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Properties = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (typeof value === 'function') made.addEventListener(name.slice(2), value);
    else setAttribute(made, name, value);
  }
  made.append(...children.filter((child): child is Node | string => Boolean(child)));
  return made;
}

export function setAttribute(
  target: Element,
  name: string,
  value: string | number | boolean | null | undefined,
): void {
  if (value === false || value === null || value === undefined) target.removeAttribute(name);
  else target.setAttribute(name, value === true ? '' : String(value));
}

/** Writes a text only where it differs: screen readers and layout notice every writing. */
export function setText(target: Element, text: string): void {
  if (target.textContent !== text) target.textContent = text;
}

let made = 0;

/** An id for a label, a description or a tab that nothing else on the page has. */
export function freshId(stem: string): string {
  made += 1;
  return `${stem}-${made}`;
}
