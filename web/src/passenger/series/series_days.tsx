import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { hasEnded } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { formatDate, formatTime, isoDate } from "../../shared/texts/times";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import type { SeriesTicket } from "./series_card";

type Day = Schemas["DayView"];

const DAYS_SHOWN_FIRST = 7;

interface SeriesDaysProps {
  readonly ticket: SeriesTicket;
  readonly campus: Campus;
  readonly onResult: (result: Result<SeriesTicket>) => void;
}

/** The days of the booking from today on, each with its state. */
export function SeriesDays({ ticket, campus, onResult }: SeriesDaysProps) {
  const t = texts.value;
  const all = useSignal(false);
  const today = isoDate(new Date(campus.view.now).getTime(), ticket.timezone);
  const ahead = ticket.days.filter((day) => day.day >= today);
  const shown = all.value ? ahead : ahead.slice(0, DAYS_SHOWN_FIRST);
  return (
    <>
      <h2>{t.series_days}</h2>
      {ahead.length === 0 && <p class="empty">{t.series_no_days}</p>}
      <ul class="days">
        {shown.map((day) => (
          <li key={day.day} data-day={day.day} data-state={day.state}>
            <DayRow ticket={ticket} day={day} onResult={onResult} />
          </li>
        ))}
      </ul>
      {shown.length < ahead.length && (
        <button
          type="button"
          class="button quiet small"
          onClick={() => {
            all.value = true;
          }}
        >
          {t.series_all_days(ahead.length)}
        </button>
      )}
    </>
  );
}

function DayRow({
  ticket,
  day,
  onResult,
}: Omit<SeriesDaysProps, "campus"> & { readonly day: Day }) {
  const t = texts.value;
  const { ride } = day;
  const cancel = async () => {
    const path = { token: ticket.token, day: day.day };
    onResult(
      await resultOf(api.POST("/api/v1/series/{token}/days/{day}/cancel", { params: { path } })),
    );
  };
  const may_cancel =
    ticket.state === "active" &&
    (day.state === "planned" ||
      day.state === "trying" ||
      (day.state === "booked" &&
        (ride === null || (!hasEnded(ride.state) && ride.state !== "aboard"))));
  return (
    <>
      <div>
        <strong>{formatDate(day.day, language.value)}</strong>
        <span class={`day-state ${day.state}`}>{dayStateText(ticket, day)}</span>
      </div>
      <div class="day-buttons">
        {ride !== null && !hasEnded(ride.state) && (
          <button
            type="button"
            class="button small"
            onClick={() => goTo({ view: "ride", token: ride.token })}
          >
            {t.show_ride}
          </button>
        )}
        {may_cancel && (
          <button type="button" class="button small" onClick={() => void cancel()}>
            {t.series_cancel_day}
          </button>
        )}
      </div>
    </>
  );
}

function dayStateText(ticket: SeriesTicket, day: Day): string {
  const t = texts.value;
  const { ride } = day;
  const time = (timestamp: string) => formatTime(timestamp, language.value, ticket.timezone);
  const reason = t.reasons[day.reason] ?? day.reason_detail;
  switch (day.state) {
    case "booked":
      if (ride === null || ride.promise === null) return t.series_booked;
      if (hasEnded(ride.state)) return t.series_ride_states[ride.state] ?? t.series_booked;
      return t.pickup_window(time(ride.promise.pickup_from), time(ride.promise.pickup_to));
    case "planned":
      return t.series_planned;
    case "trying":
      return t.series_trying(reason);
    case "refused":
      return t.series_refused(reason);
    case "skipped":
      return t.series_skipped(day.reason_detail);
    case "cancelled":
      return t.series_day_cancelled;
  }
}
