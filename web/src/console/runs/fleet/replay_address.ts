/** The first part of the address of a fleet replay. No shuttle can have this id. */
export const FLEET = "@fleet";

/** What a link to a fleet replay says. Times are milliseconds since the Unix epoch. */
export interface FleetReplay {
  readonly start_ms: number;
  readonly end_ms: number;
  readonly at_ms: number;
  readonly vehicle_id: string;
}

const SECONDS_MAX = 26 * 3600;

export function idsOfFleetReplay(replay: FleetReplay): string[] {
  const { start_ms, end_ms, at_ms, vehicle_id } = replay;
  const seconds = Math.round((end_ms - start_ms) / 1000);
  return [FLEET, start_ms, seconds, Math.round(at_ms), vehicle_id].map(String).filter(Boolean);
}

/** Null for a link that was cut off or mistyped. */
export function fleetReplayOf(ids: readonly string[]): FleetReplay | null {
  const [marker, start, length, at, vehicle_id = ""] = ids;
  const [start_ms, seconds] = [Number(start), Number(length)];
  const is_sound =
    marker === FLEET &&
    Number.isSafeInteger(start_ms) &&
    start_ms >= 0 &&
    Number.isInteger(seconds) &&
    seconds >= 1 &&
    seconds <= SECONDS_MAX;
  if (!is_sound) return null;
  const end_ms = start_ms + 1000 * seconds;
  const at_ms = Number(at);
  const is_inside = at !== undefined && at_ms >= start_ms && at_ms <= end_ms;
  return { start_ms, end_ms, at_ms: is_inside ? at_ms : start_ms, vehicle_id };
}
