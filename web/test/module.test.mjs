// The module without a browser: the native commands, and how fast it is.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { here } from "./help.mjs";
import start, { Run, keep, scenarios, schemas } from "../page/pkg/wbqp.js";

await start({ module_or_path: await readFile(here("../page/pkg/wbqp_bg.wasm")) });
const B = "scenarios/push_with_disturbance.toml";

test("every plug-in is registered, once", () => {
  const { controller } = JSON.parse(schemas());
  const kinds = Object.keys(controller.$defs);
  for (const kind of [
    "task.base_position",
    "constraint.friction_pyramid",
    "reference.min_jerk",
    "robot.othex",
    "solver.active_set",
  ]) {
    assert.ok(kinds.includes(kind), kind);
  }
  // Twice registered, no configuration would load.
  for (const { path } of JSON.parse(scenarios())) new Run(path, "", 1, "").free();
});

test("commands from recorded measurements of B are the native ones, to the bit", async () => {
  const bytes = await readFile(here("../../target/web-test/push_with_disturbance.bin"));
  const numbers = new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  const [measured, commanded] = numbers;
  const run = new Run(B, "with_ft", 1, "");
  let [ticks, different, apart] = [0, 0, 0];
  for (let at = 2; at < numbers.length; at += measured + commanded) {
    const command = run.replay(numbers.subarray(at, at + measured));
    const native = numbers.subarray(at + measured, at + measured + commanded);
    const most = Math.max(...native.map((f, i) => Math.abs(command[i] - f)));
    // What is not a number on one side alone is different, too.
    if (!native.every((f, i) => Object.is(f, command[i]))) different++;
    apart = Math.max(apart, most);
    ticks++;
  }
  run.free();
  console.log(`${ticks} ticks, ${different} of them different, by up to ${apart} N or rad/s`);
  assert.equal(ticks, 6250);
  assert.equal(different, 0);
});

test("controller and plant run B at twenty times real time", () => {
  let [best, wall] = [0, 0];
  // Seconds of the processor, all threads: other programs use it as well. The first runs compile, and a processor that
  // is shared is slow for seconds.
  for (let i = 0; i < 20 && best < 20; i++) {
    const run = new Run(B, "with_ft", 1, "");
    const [cpu, begin] = [process.cpuUsage(), performance.now()];
    while (!run.is_over() && !run.is_stopped()) run.advance(500);
    const { user, system } = process.cpuUsage(cpu);
    best = Math.max(best, (1e6 * run.time()) / (user + system));
    wall = Math.max(wall, (1e3 * run.time()) / (performance.now() - begin));
    run.free();
  }
  console.log(`B at ${best.toFixed(1)} times real time of the processor's, ${wall.toFixed(1)} of the clock's`);
  assert.ok(best >= 20, `${best}`);
});

test("what matters in a tick is told within a tenth of a second", () => {
  for (const { path, name, case: first } of JSON.parse(scenarios())) {
    const run = new Run(path, first, 1, "");
    assert.equal(JSON.parse(run.matters()).time, null);
    run.advance(200);
    let best = Infinity;
    for (let i = 0; i < 10; i++) {
      const begin = performance.now();
      const matters = JSON.parse(run.matters());
      best = Math.min(best, performance.now() - begin);
      assert.ok(matters.time > 0 && matters.effects.length === 6, name);
    }
    console.log(`${name}: what matters in ${best.toFixed(1)} ms`);
    assert.ok(best < 100, `${name}: ${best}`);
    run.forget_matters();
    run.advance(1);
    assert.equal(JSON.parse(run.matters()).time, null);
    run.free();
  }
});

test("what is wrong is thrown in words, and the module goes on", () => {
  assert.throws(() => new Run("nothing.toml", "", 1, ""), /nothing.toml: cannot be read/);
  assert.throws(() => new Run(B, "withft", 1, ""), /there is no case `withft`.*did you mean/);
  keep("own/bad.toml", new TextEncoder().encode("name = 3\n"));
  assert.throws(() => new Run("own/bad.toml", "", 1, ""), /own\/bad.toml:1:8: /);
  const run = new Run(B, "", 1, "");
  assert.throws(() => run.change('{"do":"set","of":"posture","keys":{"kp":-1}}'), /kp/);
  assert.equal(run.advance(10), 10);
  run.free();
});
