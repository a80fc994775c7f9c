// The page fits into 4 MB, compressed.
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { here } from "./help.mjs";

test("4 MB compressed are enough", () => {
  let total = 0;
  for (const name of readdirSync(here("../dist"), { recursive: true, withFileTypes: true })) {
    if (!name.isFile()) continue;
    const size = gzipSync(readFileSync(join(name.parentPath, name.name)), { level: 9 }).length;
    console.log(`${name.name}: ${(size / 1e3).toFixed(0)} kB`);
    total += size;
  }
  assert.ok(total <= 4e6, `${total}`);
});
