/** By how many whole minutes `expected` is later than the promised `latest`; 0 if the promise is kept. */
export function lateMinutes(expected: string | null, latest: string): number {
  if (expected === null) return 0;
  const late_ms = Date.parse(expected) - Date.parse(latest);
  return late_ms <= 0 ? 0 : Math.max(1, Math.round(late_ms / 60_000));
}
