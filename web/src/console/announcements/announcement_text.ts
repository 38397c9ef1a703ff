import { vehicleName } from "../texts/names";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import type { AnnouncementBody } from "./announcement_draft";

/** "Stops: ... Main Library, Gymnasium" */
export function addresseesOf(
  one: Pick<AnnouncementBody, "audience" | "stop_ids" | "vehicle_ids">,
): string {
  const t = texts.value;
  const audience = one.audience ?? "all";
  if (audience === "all") return t.audiences.all;
  const names =
    audience === "stops"
      ? (one.stop_ids ?? []).map(stopName)
      : (one.vehicle_ids ?? []).map(vehicleName);
  if (names.length > 0) return names.join(", ");
  return audience === "stops" ? t.every_stop : t.every_shuttle;
}

export function timesOf(one: Pick<AnnouncementBody, "starts_at" | "ends_at">): string {
  const t = texts.value;
  const from = one.starts_at == null ? "" : `${t.from_time(formatDateTime(one.starts_at))} `;
  return one.ends_at == null
    ? `${from}${t.announcement_until_ended}`
    : `${from}${t.until_time(formatDateTime(one.ends_at))}`;
}
