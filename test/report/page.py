"""The page: one self-contained HTML file with light and dark colours, sortable tables, and no request to anywhere."""
import collections
import html
import json
import re

STYLE = '''
:root { color-scheme: light dark; --ink: #18222c; --paper: #ffffff; --faint: #d4dae0; --soft: #f3f5f7; --accent: #2367d1;
  --good: #137a4b; --bad: #b3123f; }
@media (prefers-color-scheme: dark) { :root:not([data-theme=light]) { --ink: #dfe6ec; --paper: #14191e; --faint: #39434d;
  --soft: #1d242b; --accent: #7fb0ff; --good: #5fd39d; --bad: #ff7a9c; } }
:root[data-theme=dark] { --ink: #dfe6ec; --paper: #14191e; --faint: #39434d; --soft: #1d242b; --accent: #7fb0ff;
  --good: #5fd39d; --bad: #ff7a9c; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 1.5rem; font: 15px/1.5 system-ui, sans-serif; color: var(--ink);
  background: var(--paper); }
h1 { font-size: 1.7rem; line-height: 1.2; } h2 { margin-top: 2.5rem; border-bottom: 1px solid var(--faint); }
h3 { margin-top: 2rem; } a { color: var(--accent); }
.lead { font-size: 1.05rem; } nav { columns: 4 14rem; font-size: 0.9rem; } nav a { display: block; }
figure { margin: 0.8rem 0; overflow-x: auto; } figure svg { width: 100%; height: auto; max-width: 60rem; max-height: 44rem; }
figure svg text { font-family: system-ui, sans-serif !important; }
figcaption, .note { font-size: 0.88rem; opacity: 0.85; }
.table { overflow-x: auto; } table { border-collapse: collapse; font-size: 0.85rem; font-variant-numeric: tabular-nums; }
th, td { padding: 0.2rem 0.6rem; text-align: right; border-bottom: 1px solid var(--faint); white-space: nowrap; }
td.text, th.text { text-align: left; white-space: normal; min-width: 7rem; }
th { position: sticky; top: 0; background: var(--soft); cursor: pointer; user-select: none; }
th[aria-sort=ascending]::after { content: " \\25b4"; } th[aria-sort=descending]::after { content: " \\25be"; }
tr.failed td { color: var(--bad); } tr.led td { background: var(--faint); } td.won { color: var(--good); } td.lost { color: var(--bad); }
pre { background: var(--soft); padding: 0.7rem; overflow-x: auto; font-size: 0.82rem; }
details { margin: 0.6rem 0; } summary { cursor: pointer; color: var(--accent); }
button { float: right; font: inherit; padding: 0.2rem 0.7rem; border: 1px solid var(--faint); border-radius: 0.4rem;
  background: var(--soft); color: var(--ink); cursor: pointer; }
.cards { display: flex; flex-wrap: wrap; gap: 0.8rem; } .cards div { background: var(--soft); border-radius: 0.5rem;
  padding: 0.6rem 1rem; } .cards b { display: block; font-size: 1.4rem; }
@media print { :root { --ink: #000; --paper: #fff; --faint: #bbb; --soft: #f4f4f4; } button { display: none; }
  body { max-width: none; padding: 0; font-size: 10pt; } figure, tr { break-inside: avoid; } th { position: static; }
  details:not([open]) { display: none; } }
'''

SCRIPT = '''
document.addEventListener('click', event => {
  const head = event.target.closest('table.sortable th');
  if (!head) return;
  const table = head.closest('table'), column = head.cellIndex, rising = head.getAttribute('aria-sort') !== 'ascending';
  table.querySelectorAll('th').forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', rising ? 'ascending' : 'descending');
  const value = row => { const cell = row.cells[column], key = cell.dataset.key ?? cell.textContent, x = parseFloat(key);
    return Number.isNaN(x) ? key : x; };
  const rows = [...table.tBodies[0].rows].sort((a, b) => { const x = value(a), y = value(b);
    if (typeof x !== typeof y) return typeof x === 'number' ? -1 : 1;
    return (x < y ? -1 : x > y ? 1 : 0) * (rising ? 1 : -1); });
  table.tBodies[0].append(...rows);
});
const meanings = JSON.parse(document.getElementById('meanings').textContent);
const explain = root => root.querySelectorAll('td').forEach(cell => {
  const words = meanings[cell.textContent.split(' ')[0]]; if (words) cell.title = words; });
explain(document);
// Tables of runs are kept as data and built when somebody looks: there are thousands of rows.
const build = holder => {
  const data = JSON.parse(holder.querySelector('script').textContent), table = document.createElement('table');
  table.className = 'sortable';
  const head = table.createTHead().insertRow();
  data.heads.forEach((name, i) => { const cell = document.createElement('th'); cell.textContent = name;
    if (typeof (data.rows[0] ?? [])[i] === 'string') cell.className = 'text'; head.append(cell); });
  const body = table.createTBody();
  data.rows.forEach((row, i) => { const line = body.insertRow();
    line.dataset.run = i;
    if (data.failed.includes(i)) line.className = 'failed';
    row.forEach(value => { const cell = line.insertCell(); cell.textContent = value ?? '–';
      if (typeof value === 'string') cell.className = 'text'; else cell.dataset.key = value ?? 'inf'; }); });
  holder.querySelector('script').remove();
  holder.append(table);
  explain(holder);
};
document.querySelectorAll('details').forEach(part => part.addEventListener('toggle', () =>
  part.querySelectorAll('.table.later:has(script)').forEach(build)));
const leadToRun = () => {  // from a mark of a plot to its run: the last table of its scene
  const [, scene, run] = decodeURIComponent(location.hash).match(/^#run=(.+):([0-9]+)$/) ?? [];
  const holder = scene && [...document.querySelectorAll(`#scene-${CSS.escape(scene)} .table.later`)].pop();
  if (!holder) return;
  for (let part = holder.closest('details'); part; part = part.parentElement.closest('details')) part.open = true;
  if (holder.querySelector('script')) build(holder);
  document.querySelectorAll('tr.led').forEach(row => row.classList.remove('led'));
  const row = holder.querySelector(`tr[data-run="${run}"]`);
  row.classList.add('led');
  row.scrollIntoView({block: 'center'});
};
addEventListener('hashchange', leadToRun);
leadToRun();
document.getElementById('theme').addEventListener('click', () => {
  const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === 'dark'
    : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
});
addEventListener('beforeprint', () => document.querySelectorAll('details').forEach(d => d.open = true));
'''


def text(value):
    return html.escape(str(value))


def number(value, digits=3):
    """Table cell text of a number; NaN is a dash."""
    return '–' if value != value else f'{value:.{digits}g}'


class Cell:
    """A table cell: what is shown, what it is sorted by, its class."""

    def __init__(self, shown, key=None, kind=''):
        self.shown, self.key, self.kind = shown, key, kind


def table(heads, rows, row_kinds=None):
    """Sortable table. Rows hold Cells, numbers or text."""
    out = ['<div class="table"><table class="sortable"><thead><tr>']
    is_text = [bool(rows) and isinstance(rows[0][i], str) for i in range(len(heads))]
    out += [f'<th{" class=text" if left else ""}>{text(head)}</th>' for head, left in zip(heads, is_text)]
    out.append('</tr></thead><tbody>')
    for index, row in enumerate(rows):
        kind = row_kinds[index] if row_kinds else ''
        out.append(f'<tr class="{kind}">' if kind else '<tr>')
        for cell in row:
            if isinstance(cell, str):
                out.append(f'<td class=text>{text(cell)}</td>')
            elif isinstance(cell, Cell):
                key = f' data-key="{cell.key!r}"' if cell.key is not None else ''
                kind = f' class={cell.kind}' if cell.kind else ''
                out.append(f'<td{kind}{key}>{text(cell.shown)}</td>')
            else:
                key = ' data-key="inf"' if cell != cell else f' data-key="{cell!r}"'
                out.append(f'<td{key}>{number(cell)}</td>')
        out.append('</tr>')
    out.append('</tbody></table></div>')
    return ''.join(out)


def later_table(heads, rows, failed):
    """Table that the page builds when its details are opened. Rows hold text or numbers; `failed`: indices of rows."""
    def short(value):
        if isinstance(value, float):
            return None if value != value else float(f'{value:.3g}')
        return value
    data = {'heads': heads, 'rows': [[short(value) for value in row] for row in rows], 'failed': failed}
    packed = json.dumps(data, separators=(',', ':'), ensure_ascii=False).replace('</', '<\\/').replace('Infinity', '1e999')
    return f'<div class="table later"><script type="application/json">{packed}</script></div>'


def shown_failures(page):
    """Failed rows that stand in the tables of a page."""
    return sum(len(json.loads(block)['failed'])
               for block in re.findall(r'<div class="table later"><script type="application/json">(.*?)</script>', page, re.S))


def section(title, anchor, body, level=2):
    return f'<section id="{anchor}"><h{level}>{text(title)}</h{level}>{body}</section>\n'


def details(summary, body):
    return f'<details><summary>{text(summary)}</summary>{body}</details>'


def share_styles(page):
    """The page with each style that its pictures repeat written once, as a class: half of their bytes."""
    counts = collections.Counter(re.findall(r' style="([^"]*)"', page))
    classes = {style: f's{index}' for index, (style, count) in enumerate(counts.most_common()) if count > 3}
    rules = ''.join(f'.{name} {{ {style} }}\n' for style, name in classes.items())
    page = re.sub(r' style="([^"]*)"', lambda match: f' class="{classes[match.group(1)]}"' if match.group(1) in classes
                  else match.group(0), page)
    return page.replace('</style>', rules + '</style>', 1)


def document(title, lead, cards, contents, body, meanings):
    """The whole page. `cards`: (value, label); `contents`: (anchor, text); `meanings`: of methods, for hovering."""
    shown = ''.join(f'<div><b>{text(value)}</b>{text(label)}</div>' for value, label in cards)
    links = ''.join(f'<a href="#{anchor}">{text(label)}</a>' for anchor, label in contents)
    return share_styles(
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
        f'content="width=device-width, initial-scale=1"><title>{text(title)}</title><style>{STYLE}</style></head><body>'
        f'<button id="theme" type="button">light / dark</button><h1>{text(title)}</h1>{lead}'
        f'<div class="cards">{shown}</div><nav>{links}</nav>{body}'
        f'<script type="application/json" id="meanings">{json.dumps(meanings)}</script>'
        f'<script>{SCRIPT}</script></body></html>\n')
