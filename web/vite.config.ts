import { defineConfig } from "vitest/config";

const server = "http://127.0.0.1:8080";

export default defineConfig({
  build: {
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rolldownOptions: {
      input: {
        passenger: "index.html",
        console: "console.html",
        onboard: "onboard.html",
        board: "board.html",
        sw: "src/sw/sw.ts",
      },
      // A service worker keeps its address for ever, and reigns over what lies below it.
      output: {
        // Few files for the first load: each one more costs a phone a request with its headers.
        codeSplitting: {
          groups: [
            {
              name: "base",
              test: /node_modules|src\/shared\/(api\/|texts\/(language|preference|problem_texts|times)\.ts|ui\/(alerts|icons|language_switch|stepper)\.tsx|campus\/campus_geometry)/,
            },
            {
              name: "form",
              test: /src\/passenger\/(booking\/|campus\/|navigation|address|offline|page_title|token_storage|texts\/texts\.ts|ride\/tracked_ride)/,
            },
          ],
        },
        entryFileNames: ({ name }) => (name === "sw" ? "sw.js" : "assets/[name]-[hash].js"),
      },
    },
  },
  server: {
    proxy: { "/api": server, "/ws": { target: server, ws: true } },
  },
  test: { include: ["src/**/*.test.ts"], environment: "node" },
});
