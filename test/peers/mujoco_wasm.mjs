// node mujoco_wasm.mjs FOLDER: MuJoCo of FOLDER/node_modules/@mujoco/mujoco, stepped as mujoco_wasm_world.cpp tells through standard input.
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

const receive = (bytes) => {
  const buffer = Buffer.alloc(bytes);
  for (let have = 0; have < bytes;) {
    const got = fs.readSync(0, buffer, have, bytes - have);
    if (got === 0) process.exit(0);
    have += got;
  }
  return buffer;
};
const numbers = (count) => new Float64Array(receive(8 * count).buffer.slice(0));
const send = (values) => {
  const buffer = Buffer.from(values.buffer, values.byteOffset, values.byteLength);
  for (let sent = 0; sent < buffer.length;) sent += fs.writeSync(1, buffer, sent);
};

const module = pathToFileURL(path.join(path.resolve(process.argv[2]), 'node_modules/@mujoco/mujoco/mujoco.js'));
const load = (await import(module)).default;
// What it says goes to standard error: standard output is the pipe of the states.
const mujoco = await load({print: (line) => console.error(line), printErr: (line) => console.error(line)});
const [size, bodies, positions, rates, controls] = numbers(5);
const model = mujoco.MjModel.from_xml_string(receive(size).toString());
const data = new mujoco.MjData(model);
data.qpos.set(numbers(positions));
data.qvel.set(numbers(rates));
mujoco.mj_forward(model, data);
const friction = Float64Array.from(model.geom_friction);
let scale = 1;
for (;;) {
  send(Float64Array.from(data.qpos));
  send(Float64Array.from(data.qvel));
  const [wanted] = numbers(1);
  if (wanted !== scale) {
    scale = wanted;
    for (let g = 0; g < friction.length; g += 3) model.geom_friction[g] = scale * friction[g];
  }
  if (controls > 0) data.ctrl.set(numbers(controls));
  data.xfrc_applied.set(numbers(6 * bodies), 6);  // body 0 is the world
  mujoco.mj_step(model, data);
}
