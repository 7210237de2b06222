// Small drawings for buttons; their buttons carry the words.

const DRAWINGS = {
  play: '<path d="M4 2.5v11l9-5.5z" fill="currentColor" stroke="none"/>',
  pause: '<path d="M4 2.5h3v11H4zM9 2.5h3v11H9z" fill="currentColor" stroke="none"/>',
  open: '<path d="M1.5 13V3h4l1.5 2h7.5v8z"/>',
  folder: '<path d="M1.5 13V3h4l1.5 2h7.5v8zM8 7v4M6 9h4"/>',
  panel: '<path d="M1.5 2.5h13v11h-13zM10 2.5v11"/>',
  help: '<path d="M5.7 6a2.3 2.3 0 1 1 3.4 2c-.8.4-1.1.9-1.1 1.7"/><path d="M8 12v.6"/>',
  close: '<path d="M3.5 3.5l9 9M12.5 3.5l-9 9"/>',
  undo: '<path d="M5 3L2.5 5.5 5 8M2.5 5.5H10a3.5 3.5 0 0 1 0 7H6"/>',
  redo: '<path d="M11 3l2.5 2.5L11 8M13.5 5.5H6a3.5 3.5 0 0 0 0 7h4"/>',
  rename: '<path d="M2.5 13.5l.8-3L11 2.8l2.2 2.2-7.7 7.7zM9.5 4.3l2.2 2.2"/>',
  duplicate: '<path d="M5.5 5.5h8v8h-8zM10.5 5.5v-3h-8v8h3"/>',
  up: '<path d="M8 13V3M4 7l4-4 4 4"/>',
  down: '<path d="M8 3v10M4 9l4 4 4-4"/>',
  copy: '<path d="M4.5 3.5h-1v10h9v-10h-1M5.5 2h5v3h-5z"/>',
  remove: '<path d="M2.5 4.5h11M6 4.5v-2h4v2M4 4.5l.7 9h6.6l.7-9"/>',
  star: '<path d="M8 2l1.8 3.9 4.2.5-3.1 2.9.8 4.2L8 11.4l-3.7 2.1.8-4.2L2 6.4l4.2-.5z"/>',
  swap: '<path d="M2 5.5h11M10 2.5l3 3-3 3M14 10.5H3M6 7.5l-3 3 3 3"/>',
  dice: '<path d="M2.5 2.5h11v11h-11zM5.5 5.5h.01M10.5 10.5h.01M8 8h.01M10.5 5.5h.01M5.5 10.5h.01"/>',
  link: '<path d="M6.5 9.5l3-3M7 4.5l1.5-1.5a3.2 3.2 0 0 1 4.5 4.5L11.5 9M9 11.5L7.5 13A3.2 3.2 0 0 1 3 8.5L4.5 7"/>',
  zero: '<path d="M3 8a5 5 0 1 0 1.6-3.7M3 2.5v3h3"/>',
  search: '<path d="M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9M10.3 10.3l3.7 3.7"/>',
  chevron: '<path d="M4 6l4 4 4-4"/>',
  grab: '<path d="M4.5 8V4.2a1 1 0 0 1 2 0V7m0-3.8a1 1 0 0 1 2 0V7m0-2.8a1 1 0 0 1 2 0V8m0-1.8a1 1 0 0 1 2 0V10a4 4 0 0 1-4 4H8a4 4 0 0 1-3.2-1.6L2.3 9.6a1 1 0 0 1 1.6-1.2L4.5 9"/>',
  pin: '<path d="M5.5 2h5M6.5 2v4.2L4 9h8L9.5 6.2V2M8 9v5"/>',
  mirror: '<path d="M8 2v12M5.5 4.5L2 8l3.5 3.5M10.5 4.5L14 8l-3.5 3.5"/>',
} as const;

export type Icon = keyof typeof DRAWINGS;

export function icon(name: Icon): SVGSVGElement {
  const drawing = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  drawing.setAttribute('viewBox', '0 0 16 16');
  drawing.setAttribute('aria-hidden', 'true');
  drawing.classList.add('icon');
  drawing.innerHTML = DRAWINGS[name];
  return drawing;
}
