// The box of pages below the search field: what PAGES and WORDS (search_pages.py) find of the words typed, each as a beginning.
function searchPages(typed) {
  const score = new Map();
  const parts = typed.toLowerCase().match(/[a-z0-9_+-]{2,}/g) || [];
  for (const part of parts) {
    const own = new Map();
    for (const word in WORDS) {
      if (!word.startsWith(part)) continue;
      for (const [page, value] of WORDS[word]) own.set(page, Math.max(own.get(page) || 0, word === part ? 3 * value : value));
    }
    for (const [page, value] of own) score.set(page, (score.get(page) || 0) + value + 1e6);  // pages with all words come first
  }
  return [...score].sort((a, b) => b[1] - a[1] || a[0] - b[0]).slice(0, 8).map(([page]) => PAGES[page]);
}
// Doxygen makes the field when it likes: its events are heard where they arrive.
if (typeof document !== 'undefined') {
  const box = document.createElement('div');
  box.id = 'page-results';
  box.setAttribute('role', 'listbox');
  box.setAttribute('aria-label', 'pages found');
  box.hidden = true;
  document.body.append(box);
  const isField = target => target.id === 'MSearchField';
  const show = field => {
    const found = searchPages(field.value), place = field.getBoundingClientRect();
    box.hidden = found.length === 0;
    box.style.top = `${place.bottom + 4}px`;
    box.style.right = `${Math.max(4, innerWidth - place.right - 12)}px`;
    box.replaceChildren(...found.map(([file, title]) => Object.assign(document.createElement('a'), { href: file, textContent: title })));
  };
  for (const kind of ['input', 'focusin']) document.addEventListener(kind, event => { if (isField(event.target)) show(event.target); });
  document.addEventListener('keydown', event => {
    const first = box.querySelector('a');
    if (event.key === 'ArrowDown' && isField(event.target) && first && !box.hidden) { first.focus(); event.preventDefault(); }
    if (event.key === 'Escape') box.hidden = true;
  }, true);
  document.addEventListener('click', event => { if (!isField(event.target) && !box.contains(event.target)) box.hidden = true; });
}
