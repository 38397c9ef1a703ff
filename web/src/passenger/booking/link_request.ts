import { batch } from "@preact/signals";
import type { Stop } from "../../shared/campus/campus_geometry";
import { destination, pickup } from "./ride_request";

/**
 * Fills in what a printed code or another site's link asks for: `/?from=STOP&to=STOP`, each an id of the map.
 * Returns whether the link names a stop that the map does not have.
 */
export function fillFromLink(query: string, stops: readonly Stop[]): boolean {
  const asked = new URLSearchParams(query);
  const [from, to] = [asked.get("from") ?? "", asked.get("to") ?? ""];
  const has = (stop_id: string) => stops.some((stop) => stop.stop_id === stop_id);
  batch(() => {
    if (has(from)) pickup.value = from;
    if (has(to) && to !== from) destination.value = to;
  });
  return (from !== "" && !has(from)) || (to !== "" && !has(to));
}
