import type { Schemas } from "../../shared/api/client";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { formatTime } from "../../shared/texts/times";
import { texts } from "../texts/texts";

interface TripCardProps {
  readonly trip: Schemas["TripView"];
  readonly day: Schemas["TimetableDay"];
  readonly campus: Campus;
}

export function TripCard({ trip, day, campus }: TripCardProps) {
  const t = texts.value;
  const time = (timestamp: string) => formatTime(timestamp, language.value, day.timezone);
  const last_ms = Date.parse(trip.calls.at(-1)?.leave_at ?? "");
  const is_over = last_ms < Date.parse(campus.view.now);
  return (
    <article class={`card trip-card ${is_over ? "over" : ""}`} data-trip={trip.trip_id}>
      {trip.is_last_run && <p class="last-run">{t.last_run}</p>}
      {trip.state === "missed" && <p class="field-error">{t.trip_missed}</p>}
      <ol>
        {trip.calls.map((call) => (
          <li key={`${call.stop_id} ${call.leave_at}`}>
            <time>{time(call.leave_at)}</time>
            <span>
              {stopNameById(campus.stops, call.stop_id, language.value)}
              {call.is_last && !trip.is_last_run && <small>{t.last_call}</small>}
              {call.seats_left != null && <small>{t.seats_left(call.seats_left)}</small>}
            </span>
          </li>
        ))}
      </ol>
    </article>
  );
}
