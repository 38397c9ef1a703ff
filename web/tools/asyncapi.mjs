// Reads AsyncAPI documents with the official parser: node asyncapi.mjs FILE...
// Every finding is one line; with any, the exit status is 1.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

// Its ES modules have imports that Node.js does not resolve.
const { Parser } = createRequire(import.meta.url)("@asyncapi/parser");
const parser = new Parser();
let findings = 0;
for (const file of process.argv.slice(2)) {
  const { document, diagnostics } = await parser.parse(readFileSync(file, "utf8"));
  for (const { code, path, message } of diagnostics) {
    console.error(`${file}: ${path.join(".")}: ${message} (${code})`);
  }
  findings += diagnostics.length;
  if (document !== undefined) {
    console.log(`${file}: ${document.allMessages().all().length} messages`);
  }
}
process.exit(findings === 0 && process.argv.length > 2 ? 0 : 1);
