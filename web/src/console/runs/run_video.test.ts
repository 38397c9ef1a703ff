import { expect, test, vi } from "vitest";
import { following, RunVideo, type VideoSegment } from "./run_video";

const MINUTE_MS = 60_000;
const HOUR_MS = 3_600_000;

const aSegment = (camera: string, from_ms: number): VideoSegment => ({
  sha256: `${camera}-${from_ms}`,
  vehicle_id: "shuttle-1",
  camera,
  begins_at: new Date(from_ms).toISOString(),
  ends_at: new Date(from_ms + MINUTE_MS).toISOString(),
  size_bytes: 1,
});

test("a moment is shown by each camera's segment, and how far into it", async () => {
  const video = new RunVideo(async () => ({
    ok: true,
    value: [aSegment("front", 0), aSegment("front", MINUTE_MS + 100), aSegment("rear", 0)],
  }));
  await video.show(0, 5 * MINUTE_MS);
  expect(video.cameras).toEqual(["front", "rear"]);
  expect(video.at("front", 30_500)).toMatchObject({ segment: { sha256: "front-0" }, at_s: 30.5 });
  expect(video.at("front", MINUTE_MS + 1100)?.at_s).toBeCloseTo(1);
  expect(video.at("front", MINUTE_MS + 50)).toBeNull();
  expect(video.at("rear", 2 * MINUTE_MS)).toBeNull();
});

test("a long run is asked for in pieces, and a segment across two of them is there once", async () => {
  const fetch = vi.fn(async () => ({ ok: true as const, value: [aSegment("front", 6 * HOUR_MS)] }));
  const video = new RunVideo(fetch);
  await video.show(0, 13 * HOUR_MS);
  expect(fetch.mock.calls).toEqual([
    [0, 6 * HOUR_MS],
    [6 * HOUR_MS, 12 * HOUR_MS],
    [12 * HOUR_MS, 13 * HOUR_MS],
  ]);
  expect(video.segments.value).toHaveLength(1);
});

test("a playing video is left alone while it keeps up, and a standing one shows the very moment", () => {
  const video = { currentTime: 10, paused: false };
  expect(following(video, 10.2, true, 1)).toEqual({ seek_s: null, play: true, rate: 1 });
  expect(following(video, 11, true, 1)).toEqual({ seek_s: 11, play: true, rate: 1 });
  expect(following(video, 10.2, false, 1)).toEqual({ seek_s: 10.2, play: false, rate: 1 });
  expect(following(video, 12, true, 100)).toEqual({ seek_s: 12, play: false, rate: 16 });
});
