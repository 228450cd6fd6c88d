#!/usr/bin/python3
"""The page of `./run check DEVICE --report FILE.html`: one HTML file of one device or two side by side, which asks for nothing from outside.

    device_page.py OUT.html REPORT.json [REPORT.json]      (reports of device_check --report)
"""
import html
import json
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
STYLE = os.path.join(HERE, '..', '..', 'penalty_sim', 'session', 'session_page.css')  # one look for all pages
UNIT = {'translations': 'mm', 'turns': '°'}
VOLUME = {'translations': ('cm³', 1e-3), 'turns': ('°³', 1.0)}


def text(value):
    return html.escape(str(value))


def read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def region_of(device, kind):
    return next((region for region in device['regions'] if region['kind'] == kind), None)


def sides(box, unit):
    return ' × '.join(f'{2 * half:.3g}' for half in box['half']) + f' {unit} at ({", ".join(f"{c:.3g}" for c in box["centre"])})'


def ball(found, unit):
    return f'{found["half"][0]:.3g} {unit} about ({", ".join(f"{c:.3g}" for c in found["centre"])})'


def rows_of_region(kind):
    """(label, value of a device) of the table."""
    unit, (volume, scale) = UNIT[kind], VOLUME[kind]

    def of(words):
        return lambda device: (lambda region: words(region) if region else '–')(region_of(device, kind))
    return [(f'Region of {kind}, certified inside', of(lambda r: f'{scale * r["volume"]:.4g} {volume}, {100 * r["inside"]:.1f} % of the searched box')),
            ('undecided, and widest cell of it', of(lambda r: f'{100 * r["undecided"]:.2f} %, {r["width"]:.2g} {unit}'
                                                    + ('; the bound of the work ended the search' if r['exhausted'] else ''))),
            ('largest ball found, radius', of(lambda r: ball(r['ball'], unit))), ('largest ball about home, radius', of(lambda r: ball(r['homeBall'], unit))),
            ('largest box found, sides', of(lambda r: sides(r['box'], unit))), ('largest box about home, sides', of(lambda r: sides(r['homeBox'], unit))),
            ('least distance of two strings there', of(lambda r: nearest(r, True))),
            ('strings that lie on the grip’s ball there', of(lambda r: nearest(r, False))),
            ('cells, processor time', of(lambda r: f'{r["cells"]}, {r["seconds"]:.2g} s'))]


def table(devices):
    rows = [('Strings, degrees of freedom', lambda d: f'{len(d["strings"])}, {d["dof"]}'),
            ('Greatest force in every direction at home, no torque', lambda d: f'{d["home"]["force"]:.3g} N'),
            ('the same with the required torque', lambda d: f'{d["home"]["both"]:.3g} N'),
            ('Greatest torque about every axis at home, no force', lambda d: f'{d["home"]["torque"]:.3g} N·m' if d['dof'] > 3 else '–'),
            ('Singular values at home', lambda d: ', '.join(f'{value:.3g}' for value in d['home']['singular'])),
            ('Isotropy at home, least over greatest', lambda d: f'{d["home"]["isotropy"]:.3g}'),
            ('Stiffness of the strings at least tension, least direction', lambda d: f'{d["home"]["stiffness"]:.3g} N/m')]
    rows += rows_of_region('translations') + (rows_of_region('turns') if any(d['dof'] > 3 for d in devices) else [])
    head = '<tr><th scope="col"></th>' + ''.join(f'<th scope="col">{text(d["name"])}</th>' for d in devices) + '</tr>'
    body = ''.join(f'<tr><th scope="row">{text(label)}</th>' + ''.join(f'<td>{text(value(d))}</td>' for d in devices) + '</tr>' for label, value in rows)
    return f'<div class="table"><table><thead>{head}</thead><tbody>{body}</tbody></table></div>'


def figure(kind, title, what, **data):
    """A canvas of class `kind`, which the page's script draws by its `data`."""
    about = ''.join(f' data-{name}="{value}"' for name, value in data.items())
    keys = ' tabindex="0"' if kind == 'space' else ''
    return (f'<figure><figcaption><b>{text(title)}</b><small>{text(what)}</small></figcaption><canvas class="{kind}"{about}{keys} role="img" '
            f'aria-label="{text(title)}: {text(what)}"></canvas></figure>')


def pair(near):
    return f'strings {near["first"]} and {near["second"]}' if near['second'] >= 0 else f'string {near["first"]} on the grip'


def nearest(region, of_strings):
    """The pair of strings that comes nearest, or the string that lies flattest on the grip's ball."""
    found = [near for near in region['nearest'] if (near['second'] >= 0) == of_strings]
    if not found:
        return '–'
    near = min(found, key=lambda each: each['atLeast'])
    at = ', '.join(f'{c:.3g}' for c in near['at'])
    if of_strings:
        return f'{pair(near)}: {max(0, near["atLeast"]):.2g} to {near["found"]:.2g} mm, at ({at})'
    return pair(near) + (f': {near["found"]:.2g} mm into it, at ({at})' if near['found'] < 0 else f': free, {near["atLeast"]:.2g} mm')


def column(number, device):
    wanted = device['required']
    asked = f'every force up to {wanted["force"]:.3g} N' + (f' with every torque up to {wanted["torque"]:.3g} N·m' if device['dof'] > 3 else '')
    parts = [f'<h2>{text(device["name"])}</h2><p class="note">{text(device["source"])}; {text(os.path.basename(device["file"]))}. Required: {asked}.</p>']
    translations = region_of(device, 'translations')
    parts.append('<div class="cards">' + ''.join(f'<div><b>{text(value)}</b>{text(label)}</div>' for value, label in (
        (f'{device["home"]["force"]:.3g} N', 'every direction, at home'), (f'{translations["homeBall"]["half"][0]:.3g} mm', 'ball about home, radius'),
        (f'{100 * translations["inside"]:.0f} %', 'of the exits’ box'), (f'{translations["undecided"] * 100:.2f} %', 'undecided'))) + '</div>')
    for region in device['regions']:
        kind = 'grip unrotated' if region['kind'] == 'translations' else 'rotation vector of the grip, at home'
        parts.append(f'<h3>{text(region["kind"].capitalize())}</h3>')
        parts.append(figure('space', 'The border in 3-D', f'{kind}; drag to turn', device=number, region=region['kind']))
        for at, name in enumerate('xyz'):
            parts.append(figure('section', f'Section {name} = 0', kind, device=number, region=region['kind'], section=at))
    return '<section>' + ''.join(parts) + '</section>'


def document(devices):
    title = 'Workspace: ' + ' and '.join(device['name'] for device in devices)
    data = json.dumps(devices, separators=(',', ':')).replace('</', '<\\/')
    shown = ''.join(f'<option value="{value}">{text(words)}</option>' for value, words in (
        ('region', 'certified cells'), ('force', 'greatest force in every direction'), ('isotropy', 'isotropy'), ('stiffness', 'stiffness of the strings')))
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">'
            f'<title>{text(title)}</title><style>{read(STYLE)}{read(os.path.join(HERE, "device_page.css"))}</style></head><body>'
            f'<button id="theme" type="button">light / dark</button><h1>{text(title)}</h1>'
            '<p>A pose belongs to the region when the strings present all required wrenches at once within their tensions, and the lengths determine '
            'the pose (least singular value of the scaled structure matrix at least 0.1). Cells are certified inside or outside by bounds that hold '
            'throughout the cell; the others are undecided. Force, isotropy and stiffness are samples.</p>'
            f'{table(devices)}<div class="toolbar"><label>Sections show <select id="shown">{shown}</select></label><span class="scale" id="scale"></span></div>'
            f'<noscript><p>The pictures are drawn by a script in this file; the table is not.</p></noscript>'
            f'<div class="pair">{"".join(column(number, device) for number, device in enumerate(devices))}</div>'
            f'<script type="application/json" id="data">{data}</script><script>{read(os.path.join(HERE, "device_page.js"))}</script></body></html>\n')


def main():
    if not 3 <= len(sys.argv) <= 4:
        sys.exit(__doc__)
    try:
        page = document([json.loads(read(path)) for path in sys.argv[2:]])
        with open(sys.argv[1], 'w', encoding='utf-8') as out:
            out.write(page)
    except OSError as error:
        sys.exit(f'check: {error.filename}: {error.strerror}; give another place by --report')
    print(f'check: page {os.path.abspath(sys.argv[1])}')


if __name__ == '__main__':
    main()
