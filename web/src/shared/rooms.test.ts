import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { expect, test } from "vitest";

const SOURCE = resolve(dirname(fileURLToPath(import.meta.url)), "..");

/** [file, imported file], both below src/, tests left out. */
function imports(): [string, string][] {
  const files = readdirSync(SOURCE, { recursive: true, encoding: "utf8" }).filter(
    (name) => /\.tsx?$/.test(name) && !name.endsWith(".test.ts"),
  );
  return files.flatMap((file) => {
    const text = readFileSync(join(SOURCE, file), "utf8");
    const targets = [...text.matchAll(/(?:from|import)\s+"(\.[^"]+)"/g)].map((match) => match[1]!);
    return targets.map((target): [string, string] => [
      file,
      relative(SOURCE, resolve(SOURCE, dirname(file), target)),
    ]);
  });
}

function room(path: string): string {
  return path.split("/")[0]!;
}

test("passenger and console share shared/ and never each other; shared/ knows neither", () => {
  const found = imports();
  const crossing = found.filter(([file, target]) => {
    const [from, to] = [room(file), room(target)];
    return from !== to && to !== "shared";
  });
  expect(crossing).toEqual([]);
  expect(found.length).toBeGreaterThan(100);
});
