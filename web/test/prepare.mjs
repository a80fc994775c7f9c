// What the tests need beside the page: the module, and a native run to compare it with.
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { built, root } from "./programs.mjs";

const run = (command, args) => execFileSync(command, args, { cwd: root, stdio: "inherit" });

if (!existsSync(new URL("../page/pkg/wbqp_bg.wasm", import.meta.url))) run("web/build.sh", []);
// Only B is replayed and compared.
run(built().record, ["push_with_disturbance", "with_ft", "target/web-test"]);
