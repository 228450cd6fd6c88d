"""The program of the 3-D view: view3d/*.js and three.js in one piece, made by esbuild once and kept below build/."""
import base64
import glob
import os
import subprocess
import zlib

import npm_modules

TEXT = 'The 3-D view is left out: '


def bundle():
    """JavaScript that defines View3D. Raises npm_modules.Unavailable."""
    names = sorted(os.path.basename(path) for path in glob.glob(os.path.join(npm_modules.VIEW, '*.js')))
    kept = os.path.join(npm_modules.KEPT, f'view3d-{npm_modules.digest("package-lock.json", *names)}.js')
    if not os.path.exists(kept):
        modules = os.path.join(npm_modules.modules(), 'node_modules')
        fresh = f'{kept}.{os.getpid()}'
        done = subprocess.run([os.path.join(modules, 'esbuild', 'bin', 'esbuild'), 'main.js', '--bundle', '--minify', '--format=iife',
                               '--global-name=View3D', '--legal-comments=inline', '--log-level=warning', f'--outfile={fresh}'],
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
