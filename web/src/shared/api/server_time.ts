/**
 * The server's time, although the phone's clock may be an hour off.
 *
 * Each answer's `Date` header says when the server sent it, to the second. That of an answer which the
 * browser kept is older, so the latest that was ever seen counts; copies for offline do not count.
 */

let ahead_ms = Number.NEGATIVE_INFINITY;

/** The header of a copy that the service worker kept (src/sw/sw.ts): when it was kept, by this device's clock. */
export const STORED_AT = "Campusloop-Stored-At";

/** Below this a difference is the way of an answer and the header's whole seconds, and is left out. */
const NOTICED_MS = 5_000;

/** Notes when an answer was sent. */
export function noteSent(sent: string | null, now_ms = Date.now()): void {
  const sent_ms = Date.parse(sent ?? "");
  if (!Number.isNaN(sent_ms)) ahead_ms = Math.max(ahead_ms, sent_ms - now_ms);
}

/** The server's time; this device's while no answer has arrived. */
export function serverNow_ms(now_ms = Date.now()): number {
  return Number.isFinite(ahead_ms) && Math.abs(ahead_ms) > NOTICED_MS ? now_ms + ahead_ms : now_ms;
}

/** Forgets what was noted. */
export function forgetServerTime(): void {
  ahead_ms = Number.NEGATIVE_INFINITY;
}
