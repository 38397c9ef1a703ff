import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { timetable } from "../store/service";
import { stopName } from "../texts/stop_names";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatDate, formatTime } from "../texts/times";
import { TimetableEditor } from "./timetable_editor";

/** Today's trips with their states; the last run is marked. */
export function TripList() {
  const t = texts.value;
  const shown = timetable.value.value;
  const is_editing = useSignal(false);
  return (
    <section class="block card">
      <h2>{t.timetable_today}</h2>
      {timetable.problem.value !== null && <ProblemAlert problem={timetable.problem.value} />}
      {shown !== null && (
        <p class="hint">
          {formatDate(shown.day)} · {hoursText(shown)}
        </p>
      )}
      {shown !== null && shown.holiday !== null && (
        <Alert tone="warning">
          {t.holiday} {shown.holiday}
        </Alert>
      )}
      {shown?.trips.length === 0 && <p class="empty">{t.no_trips}</p>}
      {shown !== null && shown.trips.length > 0 && (
        <div class="scroller">
          <table class="table">
            <thead>
              <tr>
                {[t.timetable_trip, t.calls, t.state, t.vehicle].map((title) => (
                  <th key={title} scope="col">
                    {title}
                  </th>
                ))}
              </tr>
            </thead>
            <tbody>
              {shown.trips.map((trip) => (
                <TripRow key={trip.trip_id} trip={trip} />
              ))}
            </tbody>
          </table>
        </div>
      )}
      <RoleGate roles={["dispatcher"]}>
        {is_editing.value ? (
          <TimetableEditor
            onDone={() => {
              is_editing.value = false;
            }}
          />
        ) : (
          <button
            type="button"
            class="button"
            onClick={() => {
              is_editing.value = true;
            }}
          >
            {t.edit_timetable}
          </button>
        )}
      </RoleGate>
    </section>
  );
}

function TripRow({ trip }: { readonly trip: Schemas["TripView"] }) {
  const t = texts.value;
  const [first, last] = [trip.calls[0], trip.calls.at(-1)];
  return (
    <tr data-trip={trip.trip_id}>
      <th scope="row" class="mono">
        {trip.trip_id} {trip.is_last_run && <span class="chip calm">{t.last_run}</span>}
      </th>
      <td data-label={t.calls}>
        {first !== undefined && `${formatTime(first.leave_at)} ${stopName(first.stop_id)}`} –{" "}
        {last !== undefined && `${formatTime(last.leave_at)} ${stopName(last.stop_id)}`}
      </td>
      <td data-label={t.state}>
        <span class={`chip ${trip.state === "missed" ? "danger" : "calm"}`}>
          {t.trip_states[trip.state]}
        </span>
      </td>
      <td data-label={t.vehicle}>{trip.vehicle_id !== null && vehicleName(trip.vehicle_id)}</td>
    </tr>
  );
}

function hoursText(day: Schemas["TimetableDay"]): string {
  if (day.hours.length === 0) return texts.value.closed;
  return day.hours.map(spanText).join(", ");
}

function spanText(span: Schemas["SpanView"]): string {
  const [opens, closes] = [formatTime(span.opens_at), formatTime(span.closes_at)];
  return opens === closes ? texts.value.all_day : `${opens}–${closes}`;
}
