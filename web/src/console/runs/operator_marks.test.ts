import { expect, test } from "vitest";
import { inOrderOfTime, marksOfOperators } from "./operator_marks";

const mark = {
  mark_id: "c1",
  kind: "mark",
  at_ms: 5,
  note: "A shadow?",
  by: "ines",
  state: "done",
  in_file: true,
} as const;

test("an operator's mark keeps its note, and a recording its name", () => {
  const shown = marksOfOperators("s1", [mark, { ...mark, kind: "start_recording", note: "Rain" }]);
  expect(shown.map(({ kind, text, by, detail }) => [kind, text, by, detail])).toEqual([
    ["note", "A shadow?", "ines", "vehicle.mark"],
    ["recording", "Rain", "ines", "vehicle.start_recording"],
  ]);
});

test("a mark that the shuttle has not heard of is told as such", () => {
  const [waiting] = marksOfOperators("s1", [{ ...mark, state: "pending", in_file: false }]);
  expect(waiting!.detail).toBe("vehicle.mark pending");
});

test("marks of several sources are told in order of time", () => {
  const [first] = marksOfOperators("s1", [mark]);
  const marks = inOrderOfTime([{ ...first!, at_ms: 9 }, first!], [{ ...first!, at_ms: 7 }]);
  expect(marks.map(({ at_ms }) => at_ms)).toEqual([5, 7, 9]);
});
