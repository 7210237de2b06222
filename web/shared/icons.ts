// Small drawings for buttons; their buttons carry the words.

const DRAWINGS = {
  play: '<path d="M4 2.5v11l9-5.5z" fill="currentColor" stroke="none"/>',
  pause: '<path d="M4 2.5h3v11H4zM9 2.5h3v11H9z" fill="currentColor" stroke="none"/>',
  open: '<path d="M1.5 13V3h4l1.5 2h7.5v8z"/>',
  panel: '<path d="M1.5 2.5h13v11h-13zM10 2.5v11"/>',
  help: '<path d="M5.7 6a2.3 2.3 0 1 1 3.4 2c-.8.4-1.1.9-1.1 1.7"/><path d="M8 12v.6"/>',
  close: '<path d="M3.5 3.5l9 9M12.5 3.5l-9 9"/>',
  undo: '<path d="M5 3L2.5 5.5 5 8M2.5 5.5H10a3.5 3.5 0 0 1 0 7H6"/>',
  redo: '<path d="M11 3l2.5 2.5L11 8M13.5 5.5H6a3.5 3.5 0 0 0 0 7h4"/>',
  zero: '<path d="M3 8a5 5 0 1 0 1.6-3.7M3 2.5v3h3"/>',
  search: '<path d="M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9M10.3 10.3l3.7 3.7"/>',
  chevron: '<path d="M4 6l4 4 4-4"/>',
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
