// Fails the build when what a phone loads before a booking (page, scripts, styles, one language) outgrows its budget.
import { readdirSync, readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";

const LIMIT_KB = 36;
const LANGUAGES = ["english", "chinese"];

const page = readFileSync("dist/index.html", "utf8");
const first = new Set(
  [...page.matchAll(/(?:src|href)="\/assets\/([^"]+\.(?:js|css))"/g)].map((match) => match[1]),
);
const kb = (path) => gzipSync(readFileSync(`dist/${path}`)).length / 1000;
const sum_kb = (names) => [...names].reduce((sum, name) => sum + kb(`assets/${name}`), 0);

/** The file of a language and the files that it imports, without those of the page. */
function filesOf(language) {
  const found = readdirSync("dist/assets").find(
    (name) => name.startsWith(`${language}-`) && name.endsWith(".js"),
  );
  if (found === undefined) throw new Error(`there is no file for ${language}`);
  const text = readFileSync(`dist/assets/${found}`, "utf8");
  const imported = [...text.matchAll(/from\s*["'`]\.\/([\w.-]+\.js)["'`]/g)].map(
    (match) => match[1],
  );
  return [found, ...imported].filter((name) => !first.has(name));
}

const language_kb = Math.max(...LANGUAGES.map((language) => sum_kb(filesOf(language))));
const total_kb = kb("index.html") + sum_kb(first) + language_kb;
console.log(
  `passenger page: ${total_kb.toFixed(1)} kB gzip of ${LIMIT_KB}, ${language_kb.toFixed(1)} of them texts`,
);
if (first.size === 0 || total_kb > LIMIT_KB) {
  console.error("the passenger page is over its budget (or its files were not found)");
  process.exit(1);
}
