// node mujoco.mjs FOLDER: MuJoCo of FOLDER/node_modules/@mujoco/mujoco, stepped as mujoco_wasm_world.cpp tells.
import {load, numbers, receive, send} from './pipe.mjs';

const print = (line) => console.error(line);
const mujoco = await (await load('@mujoco/mujoco/mujoco.js')).default({print, printErr: print});
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
