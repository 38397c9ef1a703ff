import type { Scene } from "../../shared/scene/scene";

/** The newest scene at or before a time; the first scene for a time before all of them. */
export function sceneAt(scenes: readonly Scene[], at_ms: number): Scene | null {
  let [low, high] = [0, scenes.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (scenes[middle]!.at_ms <= at_ms) low = middle + 1;
    else high = middle;
  }
  return scenes[Math.max(low - 1, 0)] ?? null;
}

/** The time of the replay after `elapsed_ms` on the screen; it stops at the end. */
export function advancePlayback(
  at_ms: number,
  elapsed_ms: number,
  speed_factor: number,
  end_ms: number,
): { readonly at_ms: number; readonly ended: boolean } {
  const next_ms = at_ms + elapsed_ms * speed_factor;
  return next_ms >= end_ms ? { at_ms: end_ms, ended: true } : { at_ms: next_ms, ended: false };
}
