import type { Campus } from "../campus/campus";
import { language } from "../../shared/texts/language";
import { formatTime, formatTimeOrDateTime } from "../../shared/texts/times";
import { Alert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";

const CLOSING_SOON_MS = 60 * 60_000;

/** Warns when rides cannot be booked now, or only for a short time. */
export function ServiceAlert({ campus }: { readonly campus: Campus }) {
  const { open_now, opens_next, closes_at, holiday, now, timezone } = campus.view;
  const timeOf = (time: string) => formatTimeOrDateTime(time, now, language.value, timezone);
  if (open_now && closes_at !== null && Date.parse(closes_at) - Date.parse(now) < CLOSING_SOON_MS)
    return (
      <Alert tone="warning">
        {texts.value.closes_soon(formatTime(closes_at, language.value, timezone))}
      </Alert>
    );
  if (open_now) return null;
  if (holiday !== null && opens_next !== null)
    return <Alert tone="warning">{texts.value.closed_holiday(holiday, timeOf(opens_next))}</Alert>;
  return (
    <Alert tone="warning">
      {opens_next === null ? texts.value.closed : texts.value.closed_until(timeOf(opens_next))}
    </Alert>
  );
}
