import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_shape";
import { BackIcon } from "../../shared/ui/icons";
import { Loading, Note, ProblemNote } from "../../shared/ui/notes";
import { language } from "../../shared/words/language";
import { clockTime } from "../../shared/words/moments";
import { goTo } from "../navigation";
import { words } from "../texts/words";

type Day = Schemas["TimetableDay"];

/** Today's trips, each with the stops it calls at, and which run is the last. */
export function TimetablePanel({ campus }: { readonly campus: Campus }) {
  const shown = useSignal<Day | null>(null);
  const problem = useSignal<Problem | null>(null);
  const say = words.value;
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
          {say.back}
        </button>
        <h1>{say.timetable_today}</h1>
      </header>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {day === null && problem.value === null && <Loading text={say.timetable_loading} />}
      {day !== null && day.holiday !== null && <Note>{say.holiday(day.holiday)}</Note>}
      {day?.trips.length === 0 && <p class="empty">{say.timetable_empty}</p>}
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
  const say = words.value;
  const time = (moment: string) => clockTime(moment, language.value, day.timezone);
  const last_ms = Date.parse(trip.calls.at(-1)?.leave_at ?? "");
  const is_over = last_ms < Date.parse(campus.view.now);
  return (
    <article class={`card trip-card ${is_over ? "over" : ""}`} data-trip={trip.trip_id}>
      {trip.is_last_run && <p class="last-run">{say.last_run}</p>}
      {trip.state === "missed" && <p class="wrong">{say.trip_missed}</p>}
      <ol>
        {trip.calls.map((call) => (
          <li key={`${call.stop_id} ${call.leave_at}`}>
            <time>{time(call.leave_at)}</time>
            <span>
              {nameOfStop(campus.shape.stops, call.stop_id, language.value)}
              {call.is_last && !trip.is_last_run && <small>{say.last_call}</small>}
            </span>
          </li>
        ))}
      </ol>
    </article>
  );
}
