import { defineConfig } from "vite";

// Relative addresses: the page may lie in any folder of any host.
export default defineConfig({
  base: "./",
  worker: { format: "es" },
  build: { target: "es2022", chunkSizeWarningLimit: 1500 },
});
