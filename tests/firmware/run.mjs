// Runs a WebAssembly image: node run.mjs IMAGE.wasm
import { readFileSync } from "node:fs";

const decoder = new TextDecoder();
let memory;
const print = (start, length) => {
  process.stdout.write(decoder.decode(new Uint8Array(memory.buffer, start, length)));
};
const module = new WebAssembly.Module(readFileSync(process.argv[2]));
const { exports } = new WebAssembly.Instance(module, { host: { print } });
memory = exports.memory;
process.exitCode = exports.image() ? 0 : 1;
