// Fails the build when the passenger page's JavaScript outgrows what a phone should have to load.
import { readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const LIMIT_KB = 40;
const page = readFileSync("dist/index.html", "utf8");
const scripts = [...page.matchAll(/(?:src|href)="(\/assets\/[^"]+\.js)"/g)].map(
  (match) => match[1],
);
const bytes = scripts.map((path) => gzipSync(readFileSync(`dist${path}`)).length);
const total_kb = bytes.reduce((sum, size) => sum + size, 0) / 1000;
console.log(
  `passenger page: ${scripts.length} scripts, ${total_kb.toFixed(1)} kB gzip of ${LIMIT_KB}`,
);
if (scripts.length === 0 || total_kb > LIMIT_KB) {
  console.error("the passenger page is over its budget (or its scripts were not found)");
  process.exit(1);
}
