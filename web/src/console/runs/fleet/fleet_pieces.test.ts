import { expect, test, vi } from "vitest";
import type { Result } from "../../../shared/api/problem";
import type { Schemas } from "../../../shared/api/client";
import { FINE, FleetPieces } from "./fleet_pieces";

const LATER_MS = 1e12;

type Positions = Schemas["FleetPositions"];

function positions(from_ms: number, to_ms: number): Result<Positions> {
  const track = {
    vehicle_id: "shuttle-1",
    at_ms: [from_ms],
    x_m: [0],
    y_m: [0],
    yaw_rad: [0],
    speed_mps: [0],
    mode: ["held" as const],
    battery_ratio: [1],
  };
  return { ok: true, value: { from_ms, to_ms, tracks: [track] } };
}

test("a piece is asked for once, and then there", async () => {
  const asked: number[] = [];
  const pieces = new FleetPieces(
    () => LATER_MS,
    (from_ms, seconds) => {
      asked.push(from_ms);
      return Promise.resolve(positions(from_ms, from_ms + 1000 * seconds));
    },
  );
  expect(pieces.at(125_000, FINE)).toBeNull();
  await Promise.all([pieces.load(125_000, FINE), pieces.load(130_000, FINE)]);
  await pieces.load(170_000, FINE);
  expect(asked).toEqual([120_000]);
  expect(pieces.at(179_999, FINE)![0]!.at_ms).toEqual([120_000]);
  expect(pieces.at(180_000, FINE)).toBeNull();
});

test("an answer that reaches less far is completed", async () => {
  const pieces = new FleetPieces(
    () => LATER_MS,
    (from_ms) => Promise.resolve(positions(from_ms, from_ms + 25_000)),
  );
  await pieces.load(0, FINE);
  expect(pieces.at(0, FINE)![0]!.at_ms).toEqual([0, 25_000, 50_000]);
});

test("after a failure the problem is told, and nothing is asked for a while", async () => {
  let asked = 0;
  const pieces = new FleetPieces(
    () => LATER_MS,
    () => {
      asked += 1;
      return Promise.resolve({ ok: false, problem: { status: 503, code: "away", detail: "" } });
    },
  );
  await pieces.load(0, FINE);
  await pieces.load(0, FINE);
  expect(asked).toBe(1);
  expect(pieces.problem.value?.code).toBe("away");
  expect(pieces.at(0, FINE)).toBeNull();
});

test("old pieces make room for new ones", async () => {
  const pieces = new FleetPieces(
    () => LATER_MS,
    (from_ms, seconds) => Promise.resolve(positions(from_ms, from_ms + 1000 * seconds)),
  );
  for (let number = 0; number < 60; number += 1) await pieces.load(60_000 * number, FINE);
  expect(pieces.at(0, FINE)).toBeNull();
  expect(pieces.at(60_000 * 59, FINE)).not.toBeNull();
});

test("a piece that reaches into the present is loaded again some seconds later", async () => {
  vi.useFakeTimers({ toFake: ["performance"] });
  let asked = 0;
  const pieces = new FleetPieces(
    () => 30_000,
    (from_ms, seconds) => {
      asked += 1;
      return Promise.resolve(positions(from_ms, from_ms + 1000 * seconds));
    },
  );
  await pieces.load(20_000, FINE);
  await pieces.load(20_000, FINE);
  expect(asked).toBe(1);
  vi.advanceTimersByTime(6_000);
  await pieces.load(20_000, FINE);
  expect(asked).toBe(2);
  vi.useRealTimers();
});

test("what failed is loaded again while time stands, until the replay is closed", async () => {
  vi.useFakeTimers({ toFake: ["performance", "setTimeout", "clearTimeout"] });
  let asked = 0;
  const pieces = new FleetPieces(
    () => LATER_MS,
    (from_ms, seconds) => {
      asked += 1;
      const answer: Result<Positions> =
        asked === 1
          ? { ok: false, problem: { status: 503, code: "away", detail: "" } }
          : positions(from_ms, from_ms + 1000 * seconds);
      return Promise.resolve(answer);
    },
  );
  await pieces.load(0, FINE);
  await vi.advanceTimersByTimeAsync(2_500);
  expect(pieces.at(0, FINE)).not.toBeNull();
  expect(pieces.problem.value).toBeNull();
  pieces.close();
  vi.useRealTimers();
});
