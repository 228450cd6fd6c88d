// node wasm_runs.mjs WASM_FOLDER STEPS FILE.scene...: `NAME HASH MICROSECONDS` of each packed scene's world, as pack_scenes --run prints it
// natively, from the very program that the page has.
import fs from 'node:fs';
import {createRequire} from 'node:module';
import path from 'node:path';
import {Program} from '../../penalty_sim/browser/page/program.mjs';

const [folder, count, ...files] = process.argv.slice(2), steps = Number(count);
const make = createRequire(import.meta.url)(path.resolve(folder, 'touch.js'));
const program = await Program.load(fs.readFileSync(path.join(folder, 'touch.wasm')), make), {module} = program;
for (const file of files) {
  program.put(fs.readFileSync(file));
  const refused = program.text(module._haptic_alone());
  if (refused) { console.error(`${file}: ${refused}`); process.exit(1); }
  const times = [];
  for (let i = 0; i < steps; ++i) {
    const begin = performance.now();
    module._haptic_alone_steps(1);
    times.push(1000 * (performance.now() - begin));
  }
  times.sort((a, b) => a - b);
  console.log(path.basename(file, '.scene'), program.text(module._haptic_alone_hash()), times[steps >> 1].toFixed(3));
}
