import type { Scene, VehicleStatus } from "../../shared/scene/scene";
import { BUCKETS } from "./marks";

export type LocalizationPhase = NonNullable<VehicleStatus["localization"]>["phase"];

/** The worst first: of several in one column it is shown. */
export const PHASES: readonly LocalizationPhase[] = [
  "lost",
  "doubtful",
  "waiting",
  "gnss_only",
  "recovered",
  "tracking",
];

/** A deviation of this much or more fills the band. */
const FULL_M = 1;
/** A column that has no deviation, or nearly none, is still to be seen. */
const HEIGHT_MIN = 0.2;
/** A status counts until the next one, but not over a gap in the run. */
const GAP_MS = 2_000;

/** How well the shuttle knew where it was in one part of the timeline. */
export interface BandColumn {
  /** Whole parts of the timeline from 0 to `BUCKETS`. */
  readonly place: number;
  readonly phase: LocalizationPhase;
  /** From 0 to 1 by the greatest deviation, 1 for a metre or an unknown one. */
  readonly height: number;
}

/** In order of place; nothing for a run of an agent that does not say how well it knows its place. */
export function bandColumns(
  scenes: readonly Scene[],
  start_ms: number,
  end_ms: number,
): readonly BandColumn[] {
  const length_ms = Math.max(end_ms - start_ms, 1);
  const columns = new Map<number, BandColumn>();
  for (const [k, { at_ms, vehicles }] of scenes.entries()) {
    const localization = vehicles[0]?.status?.localization ?? null;
    if (localization === null || at_ms < start_ms || at_ms > end_ms) continue;
    const until_ms = Math.min(scenes[k + 1]?.at_ms ?? at_ms, at_ms + GAP_MS, end_ms);
    const first = placeOf(at_ms, start_ms, length_ms);
    const last = placeOf(until_ms, start_ms, length_ms);
    const height = heightOf(localization.position_std_m ?? null);
    for (let place = first; place === first || place < last; place += 1)
      columns.set(place, worse(columns.get(place), { place, phase: localization.phase, height }));
  }
  return [...columns.values()].sort((a, b) => a.place - b.place);
}

/** The share of the run's statuses in each phase, the worst first; phases that did not occur are left out. */
export function phaseShares(
  scenes: readonly Scene[],
): readonly { readonly phase: LocalizationPhase; readonly share: number }[] {
  const phases = scenes.flatMap(({ vehicles }) => vehicles[0]?.status?.localization?.phase ?? []);
  return PHASES.map((phase) => ({
    phase,
    share: phases.filter((one) => one === phase).length / Math.max(phases.length, 1),
  })).filter(({ share }) => share > 0);
}

function placeOf(at_ms: number, start_ms: number, length_ms: number): number {
  return Math.min(Math.floor((BUCKETS * (at_ms - start_ms)) / length_ms), BUCKETS - 1);
}

function heightOf(std_m: number | null): number {
  return std_m === null ? 1 : Math.min(1, Math.max(HEIGHT_MIN, std_m / FULL_M));
}

function worse(known: BandColumn | undefined, column: BandColumn): BandColumn {
  if (known === undefined) return column;
  const { phase } = PHASES.indexOf(known.phase) <= PHASES.indexOf(column.phase) ? known : column;
  return { place: column.place, phase, height: Math.max(known.height, column.height) };
}
