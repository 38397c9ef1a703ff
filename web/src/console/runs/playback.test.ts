import { expect, test } from "vitest";
import { aScene } from "../../shared/scene/scene_builders";
import { advancePlayback, sceneAt } from "./playback";

const scenes = [100, 300, 700].map((at_ms) => aScene({ at_ms }));

test.each([
  [0, 100],
  [100, 100],
  [299, 100],
  [300, 300],
  [650, 300],
  [9999, 700],
])("at %i the scene of %i is shown", (at_ms, shown_ms) => {
  expect(sceneAt(scenes, at_ms)!.at_ms).toBe(shown_ms);
});

test("a run without scenes shows nothing", () => {
  expect(sceneAt([], 5)).toBeNull();
});

test("playback advances by its speed factor and stops at the end", () => {
  expect(advancePlayback(100, 16, 5, 700)).toEqual({ at_ms: 180, ended: false });
  expect(advancePlayback(690, 16, 5, 700)).toEqual({ at_ms: 700, ended: true });
});
