import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import "../../console/texts/problem_texts";
import { problemCodes } from "./problem_texts";

test("every problem code that a page can receive has a text in both languages", () => {
  const document = readFileSync(new URL("../../../openapi.json", import.meta.url), "utf8");
  const codes = new Set([...document.matchAll(/"code": "([a-z_]+)"/g)].map((match) => match[1]!));
  // Codes that only vehicles, uploads and scripts receive.
  const for_machines = [
    "key_invalid",
    "enrolment_code_unknown",
    "enrolment_code_used",
    "segment_conflict",
    "segment_hash_wrong",
    "segment_too_large",
    "segment_unreadable",
    "command_unknown",
    "cursor_invalid",
    "token_invalid",
    "scope_missing",
    "signature_wrong",
    "webhook_invalid",
    "webhook_unknown",
    "webhook_disabled",
    "too_many_webhooks",
  ];
  for (const language of ["en", "zh-CN"] as const) {
    const known = new Set(problemCodes(language));
    const missing = [...codes].filter((code) => !known.has(code) && !for_machines.includes(code));
    expect(missing).toEqual([]);
  }
  expect(problemCodes("zh-CN")).toEqual(problemCodes("en"));
  expect(codes.size).toBeGreaterThan(20);
});
