// node mujoco.mjs FOLDER: MuJoCo of FOLDER/node_modules/@mujoco/mujoco, stepped as mujoco_wasm_world.cpp tells: one world after another.
import {load, numbers, receive, send} from './pipe.mjs';

const print = (line) => console.error(line);
const mujoco = await (await load('@mujoco/mujoco/mujoco.js')).default({print, printErr: print});
const run = ([size, bodies, positions, rates, controls]) => {
  const model = mujoco.MjModel.from_xml_string(receive(size).toString());
  const data = new mujoco.MjData(model);
  data.qpos.set(numbers(positions));
  data.qvel.set(numbers(rates));
  mujoco.mj_forward(model, data);
  const friction = Float64Array.from(model.geom_friction);
  const state = new Float64Array(positions + rates);
  let scale = 1;
  for (;;) {
    state.set(data.qpos);
    state.set(data.qvel, positions);
    send(state);
    const told = numbers(1 + controls + 6 * bodies);
    if (Number.isNaN(told[0])) break;
    if (told[0] !== scale) {
      scale = told[0];
      for (let g = 0; g < friction.length; g += 3) model.geom_friction[g] = scale * friction[g];
    }
    if (controls > 0) data.ctrl.set(told.subarray(1, 1 + controls));
    data.xfrc_applied.set(told.subarray(1 + controls), 6);  // body 0 is the world
    mujoco.mj_step(model, data);
  }
  data.delete();
  model.delete();
};
for (;;) run(numbers(5));
