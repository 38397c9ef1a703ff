const FIRST_MS = 500;
const LONGEST_MS = 15_000;

/**
 * How long to wait before attempt number `attempt`; 0 is the first after a loss. The delay doubles up to 15 s.
 * `jitter` in [0, 1) spreads phones that lost the same server at the same time.
 */
export function retryDelay_ms(attempt: number, jitter: number): number {
  const longest_ms = Math.min(FIRST_MS * 2 ** Math.min(attempt, 10), LONGEST_MS);
  return longest_ms * (0.5 + 0.5 * jitter);
}
