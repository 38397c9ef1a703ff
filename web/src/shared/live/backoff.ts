const FIRST_MS = 500;
const LONGEST_MS = 15_000;

/**
 * How long to wait before try number `attempt` (0 is the first after a loss). Doubles up to a quarter of a
 * minute; `spread` in [0, 1) draws phones apart that lost the same server at the same moment.
 */
export function retryDelay_ms(attempt: number, spread: number): number {
  const whole_ms = Math.min(FIRST_MS * 2 ** Math.min(attempt, 10), LONGEST_MS);
  return whole_ms * (0.5 + 0.5 * spread);
}
