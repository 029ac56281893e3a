// SPDX-License-Identifier: Apache-2.0
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vitest/config";

const station = "http://127.0.0.1:8471"; // for `npm run dev`

// Everything becomes a file of its own that the server sends: its content security policy allows no inline script or style and no data: URL.
export default defineConfig({
  plugins: [svelte()],
  build: {
    target: "es2022",
    cssTarget: ["chrome123", "firefox120", "safari17.5"], // light-dark()
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1000,
  },
  worker: { format: "es" },
  server: { host: "127.0.0.1", proxy: { "/api": { target: station, changeOrigin: true, headers: { origin: station }, ws: true } } },
  test: { include: ["src/**/*.test.ts"] },
});
