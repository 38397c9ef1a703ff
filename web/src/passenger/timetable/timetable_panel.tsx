import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { TripCard } from "./trip_card";

/** Today's trips, each with its stop calls; the last run is marked. */
export function TimetablePanel({ campus }: { readonly campus: Campus }) {
  const shown = useSignal<Schemas["TimetableDay"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  useEffect(() => {
    void resultOf(api.GET("/api/v1/timetable")).then((result) => {
      if (result.ok) shown.value = result.value;
      else problem.value = result.problem;
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
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {day === null && problem.value === null && <Loading text={t.timetable_loading} />}
      {day !== null && day.holiday !== null && <Alert>{t.holiday(day.holiday)}</Alert>}
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
