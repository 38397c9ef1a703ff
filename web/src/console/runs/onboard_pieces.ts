import { signal } from "@preact/signals";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { OnboardScene } from "../../shared/scene/onboard_scene";

type Moment = Readonly<Schemas["OnboardMoment"]>;

export const PIECE_MS = 10_000;
const KEPT = 30;
/** A scene is shown for so long; they come every 200 ms. */
const SHOWN_MS = 1_000;
/** A scan comes once a second, with the first scene after it. */
const SCAN_MS = 1_500;
/** While the operator drags the slider, nothing is asked for. */
const SETTLE_MS = 120;

export type FetchOnboard = (from_ms: number, seconds: number) => Promise<Result<Moment[]>>;

/** What the shuttle saw, in pieces of ten seconds that are loaded where the operator looks. */
export class OnboardPieces {
  /** Grows with every piece that arrives. */
  readonly arrived = signal(0);
  readonly problem = signal<Problem | null>(null);
  private readonly kept = new Map<number, readonly Moment[]>();
  private readonly awaited = new Set<number>();
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly fetch: FetchOnboard) {}

  close(): void {
    clearTimeout(this.timer);
  }

  /** The newest scene at or before this moment; undefined while it is not loaded, null if there is none. */
  at(at_ms: number): OnboardScene | null | undefined {
    const piece = this.kept.get(Math.floor(at_ms / PIECE_MS));
    if (piece === undefined) return undefined;
    const last = piece.findLastIndex((each) => each.at_ms <= at_ms);
    const moment = piece[last];
    if (moment === undefined || at_ms - moment.at_ms >= SHOWN_MS) return null;
    return withScan(piece.slice(0, last + 1), moment);
  }

  /** Loads what is around this moment, once the moment stays; while it plays also what comes next. */
  want(at_ms: number, playing: boolean): void {
    const number = Math.floor(at_ms / PIECE_MS);
    clearTimeout(this.timer);
    if (playing) {
      void this.load(number);
      void this.load(number + 1);
    } else this.timer = setTimeout(() => void this.load(number), SETTLE_MS);
  }

  private async load(number: number): Promise<void> {
    if (this.kept.has(number) || this.awaited.has(number)) return;
    this.awaited.add(number);
    const result = await this.fetch(number * PIECE_MS, PIECE_MS / 1000);
    this.awaited.delete(number);
    this.problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    this.kept.set(number, result.value);
    for (const oldest of this.kept.keys()) {
      if (this.kept.size <= KEPT) break;
      this.kept.delete(oldest);
    }
    this.arrived.value += 1;
  }
}

/** The moment's scene with the newest scan, and its age at the moment. */
function withScan(before: readonly Moment[], { at_ms, scene }: Moment): OnboardScene {
  const seen = before.findLast((each) => each.scene.scan != null);
  const scan = seen?.scene.scan;
  if (seen === undefined || scan == null || at_ms - seen.at_ms > SCAN_MS) return scene;
  return { ...scene, scan: { ...scan, age_s: scan.age_s + (at_ms - seen.at_ms) / 1000 } };
}

/** Of a recorded run. */
export function onboardOfRun(vehicle_id: string, boot_id: string): FetchOnboard {
  return (from_ms, seconds) =>
    resultOf(
      api.GET("/api/v1/runs/{vehicle_id}/{boot_id}/onboard", {
        params: { path: { vehicle_id, boot_id }, query: { from_ms, seconds } },
      }),
    ) as Promise<Result<Moment[]>>;
}
