import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { clockTime } from "../../shared/texts/times";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";

type Day = Schemas["TimetableDay"];

/** Today's trips, each with the stops it calls at, and which run is the last. */
export function TimetablePanel({ campus }: { readonly campus: Campus }) {
  const shown = useSignal<Day | null>(null);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  useEffect(() => {
    void answerOf(api.GET("/api/v1/timetable")).then((answer) => {
      if (answer.ok) shown.value = answer.value;
      else problem.value = answer.problem;
    });
  }, []);
  const day = shown.value;
  return (
    <section class="picker">
      <header class="picker-head">
        <button type="button" class="button quiet small" onClick={() => goTo({ view: "book" })}>
          <BackIcon />
          {t.back}
        </button>
        <h1>{t.timetable_today}</h1>
      </header>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {day === null && problem.value === null && <Loading text={t.timetable_loading} />}
      {day !== null && day.holiday !== null && <Note>{t.holiday(day.holiday)}</Note>}
      {day?.trips.length === 0 && <p class="empty">{t.timetable_empty}</p>}
      <ol class="trips">
        {day?.trips.map((trip) => (
          <li key={trip.trip_id}>
            <TripCard trip={trip} day={day} campus={campus} />
          </li>
        ))}
      </ol>
    </section>
  );
}

interface TripCardProps {
  readonly trip: Schemas["TripView"];
  readonly day: Day;
  readonly campus: Campus;
}

function TripCard({ trip, day, campus }: TripCardProps) {
  const t = texts.value;
  const time = (moment: string) => clockTime(moment, language.value, day.timezone);
  const last_ms = Date.parse(trip.calls.at(-1)?.leave_at ?? "");
  const is_over = last_ms < Date.parse(campus.view.now);
  return (
    <article class={`card trip-card ${is_over ? "over" : ""}`} data-trip={trip.trip_id}>
      {trip.is_last_run && <p class="last-run">{t.last_run}</p>}
      {trip.state === "missed" && <p class="wrong">{t.trip_missed}</p>}
      <ol>
        {trip.calls.map((call) => (
          <li key={`${call.stop_id} ${call.leave_at}`}>
            <time>{time(call.leave_at)}</time>
            <span>
              {nameOfStop(campus.shape.stops, call.stop_id, language.value)}
              {call.is_last && !trip.is_last_run && <small>{t.last_call}</small>}
            </span>
          </li>
        ))}
      </ol>
    </article>
  );
}
