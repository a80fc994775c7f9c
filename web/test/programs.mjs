// The programs that the tests need, as they are now.
import { execFileSync } from "node:child_process";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../../", import.meta.url));

/** Where each is, by name. Built with the features of the workspace's own tests: of one package alone, all that depends
    on a feature would be compiled once more. */
export function built() {
  const targets = ["--workspace", "--bin", "wbqp", "--example", "record"];
  const arguments_ = ["build", "--quiet", ...targets, "--message-format=json-render-diagnostics"];
  const stdio = ["ignore", "pipe", "inherit"];
  const said = execFileSync("cargo", arguments_, { cwd: root, stdio, maxBuffer: 1 << 28, encoding: "utf8" });
  const lines = said
    .split("\n")
    .filter(Boolean)
    .map((line) => JSON.parse(line));
  const made = lines.filter((line) => line.executable);
  return Object.fromEntries(made.map((line) => [line.target.name, line.executable]));
}
