import { signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";

export type Announcement = Schemas["CurrentAnnouncement"];

/** What an announcement must be about to concern this passenger. */
export interface Journey {
  readonly stop_ids: readonly string[];
  readonly vehicle_id: string | null;
}

const LOOK_MS = 10_000;

/** What the operators tell riders now; what came last stays when the connection is lost. */
export const announcements = signal<readonly Announcement[]>([]);

/** Those to all, to a stop of the journey, or to its shuttle. */
export function concerning(
  shown: readonly Announcement[],
  { stop_ids, vehicle_id }: Journey,
): readonly Announcement[] {
  return shown.filter((one) => {
    if (one.audience === "all") return true;
    if (one.audience === "stops")
      return one.stop_ids.length === 0
        ? stop_ids.length > 0
        : one.stop_ids.some((stop_id) => stop_ids.includes(stop_id));
    return (
      vehicle_id !== null && (one.vehicle_ids.length === 0 || one.vehicle_ids.includes(vehicle_id))
    );
  });
}

/** Asks again and again while the page is seen. Returns what ends it. */
export function watchAnnouncements(): () => void {
  const over = new AbortController();
  let timer = 0;
  const look = async () => {
    clearTimeout(timer);
    if (document.visibilityState === "visible") {
      const result = await resultOf(api.GET("/api/v1/announcements/current"));
      if (over.signal.aborted) return;
      if (result.ok) announcements.value = result.value;
    }
    timer = window.setTimeout(() => void look(), LOOK_MS);
  };
  document.addEventListener("visibilitychange", () => void look(), { signal: over.signal });
  void look();
  return () => {
    over.abort();
    clearTimeout(timer);
  };
}
