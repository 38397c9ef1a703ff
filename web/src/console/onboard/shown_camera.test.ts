import { afterEach, beforeEach, expect, test, vi } from "vitest";
import { type CameraPicture, type Cameras, CameraWatch, sourceOf } from "./shown_camera";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

const aPicture = (camera: string): CameraPicture => ({
  type: "camera_picture",
  epoch: 1,
  stamp_ns: 1,
  camera,
  state: "recording",
  cameras: ["front", "rear"],
  detail: "",
  coarse: true,
  jpeg: "/9j/",
});

function watchOf(comes: () => string) {
  const asked: string[] = [];
  const cameras: Cameras = {
    ask: async (_, camera) => {
      asked.push(camera);
      return { ok: true, value: {} };
    },
    newest: async () => ({
      ok: true,
      value: {
        vehicle_id: "s1",
        connected: true,
        now_ms: 1_000_100,
        request: "done",
        detail: "",
        received_ms: 1_000_000,
        picture: aPicture(comes()),
      },
    }),
  };
  return { watch: new CameraWatch("s1", cameras, () => Date.now()), asked };
}

test("the first camera is shown until another one is chosen, and no picture under a wrong name", async () => {
  let comes = "front";
  const { watch, asked } = watchOf(() => comes);
  await watch.ask();
  await vi.advanceTimersByTimeAsync(1);
  expect(watch.picture?.camera).toBe("front");
  await watch.choose("rear");
  expect(asked).toEqual(["", "rear"]);
  await vi.advanceTimersByTimeAsync(500);
  expect(watch.picture).toBeNull();
  comes = "rear";
  await vi.advanceTimersByTimeAsync(500);
  expect(watch.picture?.camera).toBe("rear");
  watch.close();
});

test("what came is told as old when nothing more comes", async () => {
  const { watch } = watchOf(() => "front");
  await watch.ask();
  await vi.advanceTimersByTimeAsync(1);
  expect(watch.is_present).toBe(true);
  watch.close();
  await vi.advanceTimersByTimeAsync(2_000);
  expect(watch.is_present).toBe(false);
});

test("an answer without a picture is no image", () => {
  expect(sourceOf({ ...aPicture("front"), jpeg: "" })).toBeNull();
  expect(sourceOf(null)).toBeNull();
  expect(sourceOf(aPicture("front"))).toBe("data:image/jpeg;base64,/9j/");
});
