// What the theme leaves out for people who use keys or hear a page read aloud.
addEventListener('load', () => {
  for (const title of document.querySelectorAll('.caption[role=heading]')) title.ariaLevel = 2;
  for (const [name, words] of [['sidebar', 'All pages'], ['toc', 'On this page']]) {
    document.querySelector(`.${name}-drawer`)?.setAttribute('aria-label', words);
  }
  // The corner of a table is the header of nothing.
  for (const corner of document.querySelectorAll('th')) if (!corner.textContent.trim()) corner.role = 'cell';
  const reach = () => {
    for (const box of document.querySelectorAll('pre, .table-wrapper, div.math > div')) {
      if (box.scrollWidth > box.clientWidth) box.tabIndex = 0;
      else box.removeAttribute('tabindex');
    }
  };
  reach();
  addEventListener('resize', reach);
});
