import { campus } from "../../shared/campus/campus";
import { serverNow_ms } from "../../shared/api/server_time";
import { language } from "../../shared/texts/language";
import * as times from "../../shared/texts/times";
import { link } from "../session";

type Timestamp = string | number;

function timezone(): string {
  return campus.value?.view.timezone ?? "UTC";
}

/** The server's clock, or this computer's while no message from the server has arrived. */
export function now_ms(): number {
  return link.value?.now_ms() ?? serverNow_ms();
}

export function formatTime(timestamp: Timestamp): string {
  return times.formatTime(timestamp, language.value, timezone());
}

export function formatTimeWithSeconds(timestamp: Timestamp): string {
  return times.formatTimeWithSeconds(timestamp, language.value, timezone());
}

export function formatDateTime(timestamp: Timestamp): string {
  return times.formatDateTime(timestamp, language.value, timezone());
}

export function formatTimeOrDateTime(timestamp: Timestamp): string {
  return times.formatTimeOrDateTime(timestamp, now_ms(), language.value, timezone());
}

/** "Thu 1 Oct 2026" */
export function formatDate(date: string): string {
  return times.formatDate(date, language.value, "numeric");
}
