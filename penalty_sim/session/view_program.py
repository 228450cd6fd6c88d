"""The program of the 3-D view: view3d/*.js and three.js in one piece, made by esbuild once and kept below build/."""
import base64
import glob
import os
import subprocess
import zlib

import npm_modules

TEXT = 'The 3-D view is left out: '


def bundle(entry=os.path.join(npm_modules.VIEW, 'main.js'), name='View3D'):
    """JavaScript that defines `name`, of the module `entry`, those beside it and view3d. Raises npm_modules.Unavailable."""
    sources = sorted({path for folder in (npm_modules.VIEW, os.path.dirname(entry)) for path in glob.glob(os.path.join(folder, '*.*js'))})
    kept = os.path.join(npm_modules.KEPT, f'{name}-{npm_modules.digest("package-lock.json", *sources)}.js')
    if not os.path.exists(kept):
        modules = os.path.join(npm_modules.modules(), 'node_modules')
        fresh = f'{kept}.{os.getpid()}'
        done = subprocess.run([os.path.join(modules, 'esbuild', 'bin', 'esbuild'), os.path.abspath(entry), '--bundle', '--minify', '--format=iife',
                               f'--global-name={name}', '--legal-comments=inline', '--log-level=warning', f'--outfile={fresh}'],
                              cwd=npm_modules.VIEW, env={**os.environ, 'NODE_PATH': modules}, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise npm_modules.Unavailable(f'esbuild failed: {done.stderr.strip()[:300]}')
        os.rename(fresh, kept)
    with open(kept, encoding='utf-8') as file:
        return file.read()


def packed():
    """(the program as the page keeps it, '') or ('', why there is none)."""
    try:
        return base64.b64encode(zlib.compress(bundle().encode(), 9)).decode(), ''
    except npm_modules.Unavailable as reason:
        return '', TEXT + str(reason)
