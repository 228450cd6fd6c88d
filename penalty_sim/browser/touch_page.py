#!/usr/bin/python3
"""The page on which scenes are touched: one HTML file that asks for nothing from outside.

    touch_page.py WASM_FOLDER SCENES_FOLDER OUT.html [LINK_BACK]

WASM_FOLDER has touch.js and touch.wasm, SCENES_FOLDER the files of pack_scenes. Prints how large the page is.
"""
import base64
import gzip
import html
import os
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
for folder in (('penalty_sim', 'session'), ('launch', 'doc')):
    sys.path.insert(0, os.path.join(ROOT, *folder))
import make_gallery  # noqa: E402
import npm_modules  # noqa: E402
import view_program  # noqa: E402

FIRST = 'touch_cube'  # of the list, and what the page opens


def read(*path):
    with open(os.path.join(*path), 'rb') as file:
        return file.read()


def packed(identity, raw):
    """A block of the page that holds bytes."""
    return f'<script type="application/octet-stream" id="{identity}">{base64.b64encode(zlib.compress(raw, 9)).decode()}</script>'


def options(names):
    """The list of scenes: those with a hand of their own first."""
    touched = [name for name in names if 'hand' in make_gallery.SHOWS[name].lower() or name == FIRST]
    groups = (('made for a hand', touched), ('others', [name for name in names if name not in touched]))

    def option(name):
        return f'<option value="{name}" data-shows="{html.escape(make_gallery.SHOWS[name].replace("`", ""))}">{name}</option>'
    return ''.join(f'<optgroup label="{label}">{"".join(map(option, group))}</optgroup>' for label, group in groups if group)


def page(wasm, scenes, back=''):
    names = [name for name in make_gallery.SHOWS if os.path.exists(os.path.join(scenes, name + '.scene'))]
    if FIRST not in names:
        sys.exit(f'touch_page: {scenes} has no {FIRST}.scene: call pack_scenes first')
    program = view_program.bundle(os.path.join(HERE, 'page', 'touch.js'), 'Touch')
    blocks = [packed('wasm', read(wasm, 'touch.wasm')), packed('loader', read(wasm, 'touch.js'))]
    blocks += [packed('scene-' + name, read(scenes, name + '.scene')) for name in names]
    parts = {'@STYLE@': (read(ROOT, 'penalty_sim', 'session', 'session_page.css') + read(HERE, 'page', 'touch.css')).decode(),
             '@BACK@': f'<a href="{html.escape(back)}">documentation</a>' if back else '', '@OPTIONS@': options(names), '@DATA@': '\n'.join(blocks),
             '@SCRIPT@': program.replace('</script', '<\\/script')}
    text = read(HERE, 'page', 'touch.html').decode()
    for mark, content in parts.items():
        text = text.replace(mark, content)
    return text, names


def main():
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    try:
        text, names = page(*sys.argv[1:3], *sys.argv[4:])
    except npm_modules.Unavailable as reason:
        sys.exit(f'touch_page: {reason}')
    with open(sys.argv[3], 'w', encoding='utf-8') as out:
        out.write(text)
    print(f'{sys.argv[3]}: {len(names)} scenes')
    print(f'figure wasm.kb {len(gzip.compress(text.encode(), 9)) / 1000:.1f} kB')
    print(f'figure wasm.scenes {len(names)} 1')


if __name__ == '__main__':
    main()
