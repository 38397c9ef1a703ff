import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { TextField } from "../forms/text_field";
import { vehicleName } from "../texts/names";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatDateTime, formatTime } from "../texts/times";
import type { Timetable, TimetableEffect, Trip } from "./timetable_draft";
import { TimetableDraft, withTrip } from "./timetable_draft";
import { TripForm } from "./trip_form";

/** All trips, to be changed, previewed and published as one version; earlier versions can be taken back. */
export function TimetableEditor({ onDone }: { readonly onDone: () => void }) {
  const t = texts.value;
  const draft = useMemo(() => new TimetableDraft(), []);
  const editing = useSignal<Trip | "new" | null>(null);
  useEffect(() => void draft.load(), [draft]);
  const [base, trips, effect] = [draft.base.value, draft.trips.value, draft.effect.value];
  if (base === null)
    return draft.problem.value === null ? (
      <Loading text={t.loading} />
    ) : (
      <ProblemAlert problem={draft.problem.value} />
    );
  const edited = editing.value === "new" ? null : editing.value;
  return (
    <div class="timetable-editor">
      <UnservedTrips unserved={base.unserved} />
      {effect === null && !draft.is_changed.value && <TightLegs legs={base.tight_legs} />}
      {trips.length === 0 && <p class="empty">{t.no_trips_at_all}</p>}
      <ul class="rows">
        {trips.map((trip) => (
          <li key={trip.trip_id} data-edited-trip={trip.trip_id}>
            <TripLine
              trip={trip}
              onEdit={() => {
                editing.value = trip;
              }}
              onRemove={() => draft.change(trips.filter((other) => other !== trip))}
            />
          </li>
        ))}
      </ul>
      {editing.value === null ? (
        <button
          type="button"
          class="button"
          onClick={() => {
            editing.value = "new";
          }}
        >
          {t.new_trip}
        </button>
      ) : (
        <TripForm
          key={edited?.trip_id ?? ""}
          trip={edited}
          taken_ids={trips.filter((trip) => trip !== edited).map(({ trip_id }) => trip_id)}
          onCancel={() => {
            editing.value = null;
          }}
          onDone={(trip) => {
            draft.change(withTrip(trips, trip, edited?.trip_id ?? null));
            editing.value = null;
          }}
        />
      )}
      {draft.is_outdated.value ? (
        <Conflict draft={draft} />
      ) : (
        draft.problem.value !== null && (
          <>
            <ProblemAlert problem={draft.problem.value} />
            <p class="hint">{draft.problem.value.detail}</p>
          </>
        )
      )}
      {effect !== null && <Effect effect={effect} />}
      <TextField label={t.timetable_note} value={draft.note} input={{ maxLength: 500 }} />
      <div class="buttons">
        <button
          type="button"
          class="button"
          disabled={!draft.is_changed.value || editing.value !== null}
          onClick={() => void draft.preview()}
        >
          {t.preview_timetable}
        </button>
        <button
          type="button"
          class="button main"
          disabled={effect === null}
          onClick={() => void draft.publish().then((is_published) => is_published && onDone())}
        >
          {t.publish_timetable}
        </button>
        <button type="button" class="button" onClick={onDone}>
          {t.cancel}
        </button>
      </div>
      <Versions draft={draft} />
    </div>
  );
}

interface TripLineProps {
  readonly trip: Trip;
  readonly onEdit: () => void;
  readonly onRemove: () => void;
}

function TripLine({ trip, onEdit, onRemove }: TripLineProps) {
  const t = texts.value;
  const [first, last] = [trip.calls[0], trip.calls.at(-1)];
  const callText = (call: Trip["calls"][number] | undefined) =>
    call === undefined ? "" : `${call.leaves} ${stopName(call.stop_id)}`;
  return (
    <div class="line">
      <span>
        <strong class="mono">{trip.trip_id}</strong> {callText(first)} – {callText(last)}
        <small>{trip.service_id === "" ? t.every_day_but_holidays : trip.service_id}</small>
      </span>
      <span class="buttons">
        <button type="button" class="button small" onClick={onEdit}>
          {t.edit}
        </button>
        <button type="button" class="button small" onClick={onRemove}>
          {t.remove}
        </button>
      </span>
    </div>
  );
}

function Conflict({ draft }: { readonly draft: TimetableDraft }) {
  const t = texts.value;
  return (
    <Alert tone="warning">
      <p>{t.timetable_conflict}</p>
      <div class="buttons">
        <button type="button" class="button small main" onClick={() => void draft.keepMine()}>
          {t.publish_mine_after}
        </button>
        <button type="button" class="button small" onClick={() => void draft.load()}>
          {t.load_their_timetable}
        </button>
      </div>
    </Alert>
  );
}

/** What publishing changes, and which departures it takes back. */
function Effect({ effect }: { readonly effect: TimetableEffect }) {
  const t = texts.value;
  const lines = [
    [t.trips_added, effect.added],
    [t.trips_changed, effect.changed],
    [t.trips_removed, effect.removed],
  ] as const;
  return (
    <div class="alert" role="status" data-timetable-effect>
      <ul>
        {lines.map(
          ([label, ids]) =>
            ids.length > 0 && (
              <li key={label}>
                {label} {ids.join(", ")}
              </li>
            ),
        )}
        {effect.withdrawn.map((one) => (
          <li key={one.departure_id}>
            {t.departure_withdrawn(formatTime(one.leave_at), shuttleOf(one.vehicle_id))}
          </li>
        ))}
        {effect.kept.map((one) => (
          <li key={one.departure_id}>{t.departure_kept(formatTime(one.leave_at))}</li>
        ))}
        {effect.withdrawn.length + effect.kept.length === 0 && <li>{t.no_departure_affected}</li>}
      </ul>
      <TightLegs legs={effect.tight_legs} />
    </div>
  );
}

/** Trips that the timetable has and the map cannot serve. */
function UnservedTrips({ unserved }: { readonly unserved: Timetable["unserved"] }) {
  const t = texts.value;
  if (unserved.length === 0) return null;
  return (
    <Alert tone="danger">
      <p>{t.trips_unserved_lead}</p>
      <ul data-unserved-trips>
        {unserved.map(({ trip_id, missing_stops }) => (
          <li key={trip_id}>{t.trip_unserved(trip_id, missing_stops.join(", "))}</li>
        ))}
      </ul>
    </Alert>
  );
}

function TightLegs({ legs }: { readonly legs: Timetable["tight_legs"] }) {
  const t = texts.value;
  if (legs.length === 0) return null;
  return (
    <Alert tone="warning">
      <p>{t.tight_legs_lead}</p>
      <ul data-tight-legs>
        {legs.map((leg) => (
          <li key={`${leg.trip_id} ${leg.leaves}`}>
            {t.tight_leg(leg.trip_id, stopName(leg.from_stop), stopName(leg.to_stop), leg.leaves)}{" "}
            {leg.needed_s === null
              ? t.tight_leg_no_road
              : t.tight_leg_takes(t.minutes_seconds(leg.needed_s), t.minutes_seconds(leg.given_s))}
          </li>
        ))}
      </ul>
    </Alert>
  );
}

function shuttleOf(vehicle_id: string | null): string {
  return vehicle_id === null ? texts.value.no_shuttle_yet : vehicleName(vehicle_id);
}

function Versions({ draft }: { readonly draft: TimetableDraft }) {
  const t = texts.value;
  const base = draft.base.value;
  if (base === null || base.revision === 0) return null;
  return (
    <details>
      <summary>{t.timetable_versions}</summary>
      <ul class="rows">
        {base.versions.map((version) => (
          <li key={version.revision}>
            <div class="line">
              <span>
                {version.revision}. {formatDateTime(version.made_at)}, {version.made_by}
                <small>
                  {[t.trips_of(version.trips), version.note]
                    .filter((part) => part !== "")
                    .join(" · ")}
                </small>
              </span>
              <button
                type="button"
                class="button small"
                onClick={() => void draft.take(version.revision)}
              >
                {t.take_version(version.revision)}
              </button>
            </div>
          </li>
        ))}
        <li>
          <div class="line">
            <span>{t.maps_own_timetable}</span>
            <button type="button" class="button small" onClick={() => void draft.take(0)}>
              {t.take_maps_timetable}
            </button>
          </div>
        </li>
      </ul>
    </details>
  );
}
