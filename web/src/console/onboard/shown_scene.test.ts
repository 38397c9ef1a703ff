import { afterEach, beforeEach, expect, test, vi } from "vitest";
import type { Result } from "../../shared/api/problem";
import { anOnboardScene } from "../../shared/scene/scene_builders";
import { SHOWN_MS } from "./requested_watch";
import { SceneWatch, type Scenes } from "./shown_scene";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

function watchOf(ask: Result<unknown>) {
  let looks = 0;
  const scenes: Scenes = {
    ask: async () => ask,
    newest: async () => {
      looks += 1;
      return {
        ok: true,
        value: {
          vehicle_id: "s1",
          connected: true,
          now_ms: 1_000_000 + looks,
          request: "done",
          detail: "",
          received_ms: 999_900 + looks,
          scene: anOnboardScene(),
        },
      };
    },
  };
  return { watch: new SceneWatch("s1", scenes, () => Date.now()), looks: () => looks };
}

test("scenes are looked for until the minute is over, and a further request is one minute more", async () => {
  const { watch, looks } = watchOf({ ok: true, value: {} });
  await watch.ask();
  await vi.advanceTimersByTimeAsync(SHOWN_MS / 2);
  expect(watch.watching.value).toBe(true);
  await watch.ask();
  await vi.advanceTimersByTimeAsync(SHOWN_MS - 1000);
  expect(watch.watching.value).toBe(true);
  await vi.advanceTimersByTimeAsync(2000);
  expect(watch.watching.value).toBe(false);
  const before = looks();
  await vi.advanceTimersByTimeAsync(5000);
  expect(looks()).toBe(before);
});

test("the age of what is shown grows while nothing comes", async () => {
  const { watch } = watchOf({ ok: true, value: {} });
  expect(watch.age_ms).toBeNull();
  await watch.ask();
  await vi.advanceTimersByTimeAsync(1);
  watch.close();
  const age_ms = watch.age_ms!;
  expect(watch.present).not.toBeNull();
  expect(age_ms).toBeGreaterThanOrEqual(100);
  await vi.advanceTimersByTimeAsync(3000);
  expect(watch.age_ms! - age_ms).toBe(3000);
  // It is told as old, and no longer drawn as the present.
  expect(watch.present).toBeNull();
});

test("a shuttle out of reach is not looked at", async () => {
  const problem = { code: "vehicle_not_connected" } as never;
  const { watch, looks } = watchOf({ ok: false, problem });
  await watch.ask();
  await vi.advanceTimersByTimeAsync(1000);
  expect([watch.problem.value, watch.watching.value, looks()]).toEqual([problem, false, 0]);
});
