import { expect, test, vi } from "vitest";
import { anOnboardScene } from "../../shared/scene/scene_builders";
import { OnboardPieces, PIECE_MS } from "./onboard_pieces";

function moments(...at_ms: number[]) {
  return at_ms.map((at) => ({ at_ms: at, scene: anOnboardScene({ stamp_ns: at }) }));
}

test("a moment shows the newest scene before it, and none that is older than a second", async () => {
  const pieces = new OnboardPieces(async () => ({ ok: true, value: moments(200, 400) }));
  expect(pieces.at(300)).toBeUndefined();
  pieces.want(300, true);
  await vi.waitFor(() => expect(pieces.arrived.value).toBe(2));
  expect(pieces.at(300)?.stamp_ns).toBe(200);
  expect(pieces.at(450)?.stamp_ns).toBe(400);
  expect(pieces.at(100)).toBeNull();
  expect(pieces.at(1500)).toBeNull();
});

test("dragging loads only where the slider comes to rest, and each piece once", async () => {
  vi.useFakeTimers();
  const asked: number[] = [];
  const pieces = new OnboardPieces(async (from_ms) => {
    asked.push(from_ms);
    return { ok: true, value: [] };
  });
  for (let at_ms = 0; at_ms <= 5 * PIECE_MS; at_ms += PIECE_MS) pieces.want(at_ms, false);
  await vi.advanceTimersByTimeAsync(1000);
  pieces.want(5 * PIECE_MS + 7, false);
  await vi.advanceTimersByTimeAsync(1000);
  expect(asked).toEqual([5 * PIECE_MS]);
  vi.useRealTimers();
});

test("a piece that did not come is told, and asked for again", async () => {
  const problem = { code: "x" } as never;
  let ok = false;
  const pieces = new OnboardPieces(async () =>
    ok ? { ok, value: moments(0) } : { ok: false, problem },
  );
  pieces.want(0, true);
  await vi.waitFor(() => expect(pieces.problem.value).toBe(problem));
  ok = true;
  pieces.want(0, true);
  await vi.waitFor(() => expect(pieces.at(0)?.stamp_ns).toBe(0));
  expect(pieces.problem.value).toBeNull();
});

test("a scan is shown until the next one, with its age at the moment, and not much longer", async () => {
  const scan = { x_m: 0, y_m: 0, age_s: 0.1, offsets_cm: "" };
  const value = moments(0, 200, 400, 1600, 1800);
  value[1]!.scene = anOnboardScene({ stamp_ns: 200, scan });
  const pieces = new OnboardPieces(async () => ({ ok: true, value }));
  pieces.want(0, true);
  await vi.waitFor(() => expect(pieces.arrived.value).toBe(2));
  expect(pieces.at(100)?.scan).toBeNull();
  expect(pieces.at(250)?.scan?.age_s).toBeCloseTo(0.1);
  expect(pieces.at(1650)?.scan?.age_s).toBeCloseTo(1.5);
  expect(pieces.at(1650)?.stamp_ns).toBe(1600);
  expect(pieces.at(1800)?.scan).toBeNull();
});
