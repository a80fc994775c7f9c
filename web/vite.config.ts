import license from "rollup-plugin-license";
import { defineConfig } from "vite";

// Relative addresses: the page may lie in any folder of any host.
export default defineConfig({
  base: "./",
  worker: { format: "es" },
  build: { target: "es2022", chunkSizeWarningLimit: 1500 },
  // Licences of what is bundled; minified code has lost them. The module's own crates: `.ci/release`.
  plugins: [license({ thirdParty: { output: { file: "dist/third_party_npm.txt" } } })],
});
