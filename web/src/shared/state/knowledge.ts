/** What a page knows: the server's clock now, and at what time of that clock its newest news was true. */
export interface Knowledge {
  readonly now_ms: number;
  readonly known_ms: number;
  /** The connection is known to be lost, so that no news can come. */
  readonly is_cut_off?: boolean;
}

/** The server says something at least every 5 s. Older news is the past, not the present. */
export const OLD_MS = 7_000;

export function isOld({ now_ms, known_ms, is_cut_off = false }: Knowledge): boolean {
  return is_cut_off || now_ms - known_ms > OLD_MS;
}
