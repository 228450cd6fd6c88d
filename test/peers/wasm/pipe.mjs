// Standard input and output as streams of numbers, for engines that are told each step by wasm_world.cpp and mujoco_wasm_world.cpp.
import fs from 'node:fs';
import path from 'node:path';
import {pathToFileURL} from 'node:url';

export const receive = (bytes) => {
  const buffer = Buffer.alloc(bytes);
  for (let have = 0; have < bytes;) {
    const got = fs.readSync(0, buffer, have, bytes - have);
    if (got === 0) process.exit(0);
    have += got;
  }
  return buffer;
};
export const numbers = (count) => new Float64Array(receive(8 * count).buffer.slice(0));
export const send = (values) => {
  const buffer = Buffer.from(values.buffer, values.byteOffset, values.byteLength);
  for (let sent = 0; sent < buffer.length;) sent += fs.writeSync(1, buffer, sent);
};

// What a package says goes to standard error: standard output is the pipe of the states.
console.log = console.info = console.error;
export const load = async (file) => import(pathToFileURL(path.join(path.resolve(process.argv[2]), 'node_modules', file)));
