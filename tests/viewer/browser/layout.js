// What stands where on a page: controls and words that hide each other, and words cut off.
// Returns sentences; none where everything is in order.
() => {
  // Pins lie on the face, which takes what is pressed there.
  const CONTROLS =
    'button:not(.pin), select, textarea, a[href], summary, [role=slider], [role=tab], label, ' +
    'input:not([hidden], [type=file], [type=checkbox], [type=radio])';
  const WORDS = '.status, .model-name, .legend-title, .message p, .tip, h1';
  const dialog = document.querySelector('dialog[open]');
  const root = dialog ?? document;
  const name = (e) =>
    `${e.tagName.toLowerCase()}${e.className && typeof e.className === 'string' ? '.' + e.className.split(' ')[0] : ''} ` +
    `“${(e.getAttribute('aria-label') ?? e.textContent ?? '').trim().slice(0, 30)}”`;
  const shown = (e) => e.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });
  // The part of an element that its scrolling ancestors let through.
  const visible = (e) => {
    let { left, top, right, bottom } = e.getBoundingClientRect();
    for (let up = e.parentElement; up; up = up.parentElement) {
      if (getComputedStyle(up).overflow === 'visible') continue;
      const box = up.getBoundingClientRect();
      left = Math.max(left, box.left); top = Math.max(top, box.top);
      right = Math.min(right, box.right); bottom = Math.min(bottom, box.bottom);
    }
    return { left, top, right, bottom, width: right - left, height: bottom - top };
  };
  const found = [];
  const things = [...root.querySelectorAll(`${CONTROLS}, ${WORDS}`)]
    .filter(shown)
    .map((element) => ({ element, box: visible(element) }))
    .filter(({ box }) => box.width > 3 && box.height > 3);
  for (let i = 0; i < things.length; i += 1) {
    for (let j = i + 1; j < things.length; j += 1) {
      const [a, b] = [things[i], things[j]];
      if (a.element.contains(b.element) || b.element.contains(a.element)) continue;
      // The line of the swipe runs over the whole picture; only its knob must be free.
      if ([a, b].some(({ element }) => element.matches('.swipe'))) continue;
      // A message lies over the picture until it has been read; names there can wait, controls not.
      if (a.element.matches('.message p, .model-name') && b.element.matches('.message p, .model-name')) continue;
      const across = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
      const high = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
      if (across > 1.5 && high > 1.5) found.push(`${name(a.element)} and ${name(b.element)} overlap`);
    }
  }
  // Upwards and downwards there is scrolling; what is cut off at a side is lost.
  for (const element of [...root.querySelectorAll(`${CONTROLS}, ${WORDS}`)].filter(shown)) {
    const [box, whole] = [visible(element), element.getBoundingClientRect()];
    if (box.height > 3 && whole.width > 3 && box.width < whole.width - 1) found.push(`${name(element)} is cut off`);
  }
  for (const { element, box } of things) {
    const outside = box.left < -0.5 || box.right > innerWidth + 0.5 || box.top < -0.5 || box.bottom > innerHeight + 0.5;
    if (outside) found.push(`${name(element)} reaches beyond the window`);
    // Whoever points at the middle of a control must hit it, not something that lies over it.
    if (!element.matches(CONTROLS) || element.disabled || element.matches('label')) continue;
    const at = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
    const own = at && (element.contains(at) || at.contains(element));
    if (!own) found.push(`${name(element)} is hidden by ${at ? name(at) : 'nothing'}`);
    if (element.matches('button, select') && (box.width < 15.5 || box.height < 15.5) && element.getBoundingClientRect().height === box.height) {
      found.push(`${name(element)} is only ${box.width.toFixed(0)} × ${box.height.toFixed(0)}`);
    }
  }
  const wide = document.documentElement;
  if (wide.scrollWidth > innerWidth) found.push(`the page is ${wide.scrollWidth} wide, the window ${innerWidth}`);
  if (wide.scrollHeight > innerHeight) found.push(`the page is ${wide.scrollHeight} high, the window ${innerHeight}`);
  for (const panel of document.querySelectorAll('.panel [role=tabpanel]')) {
    if (shown(panel) && panel.scrollWidth > panel.clientWidth + 1) found.push('the panel scrolls sideways');
  }
  return found;
}
