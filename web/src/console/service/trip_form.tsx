import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { campus } from "../../shared/campus/campus";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { service } from "../store/service";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import type { Trip } from "./timetable_draft";

type TripCall = Trip["calls"][number];

interface TripFormProps {
  /** null for a new trip. */
  readonly trip: Trip | null;
  /** Of the other trips. */
  readonly taken_ids: readonly string[];
  readonly onDone: (trip: Trip) => void;
  readonly onCancel: () => void;
}

const CALLS_MIN = 2;

/** One trip: the days by its service, and its stops with their times. The server checks them. */
export function TripForm({ trip, taken_ids, onDone, onCancel }: TripFormProps) {
  const t = texts.value;
  const stops = campus.value?.geometry.stops ?? [];
  const trip_id = useSignal(trip?.trip_id ?? "");
  const service_id = useSignal(trip?.service_id ?? "");
  const blank = { stop_id: stops[0]?.stop_id ?? "", leaves: "" };
  const calls = useSignal<readonly TripCall[]>(trip?.calls ?? [blank, blank]);
  const is_taken = taken_ids.includes(trip_id.value);
  const change = (number: number, changed: Partial<TripCall>) => {
    calls.value = calls.value.map((call, at) => (at === number ? { ...call, ...changed } : call));
  };
  const patterns = service.value.value?.patterns ?? [];
  const submit = (event: Event) => {
    event.preventDefault();
    if (is_taken) return;
    onDone({
      trip_id: trip_id.value,
      service_id: service_id.value,
      calls: calls.value.map((call) => ({ ...call })),
    });
  };
  return (
    <form class="grid-form trip-form" onSubmit={submit}>
      <TextField
        label={t.trip_id}
        value={trip_id}
        hint={is_taken ? t.trip_id_taken : t.id_hint}
        input={{
          required: true,
          pattern: "[A-Za-z0-9][A-Za-z0-9._@:\\-]{0,63}",
          autocomplete: "off",
        }}
      />
      <SelectField
        label={t.trip_service}
        value={service_id.value}
        options={[
          ["", t.every_day_but_holidays],
          ...patterns.map(({ service_id: id, name }) => [id, name] as const),
        ]}
        onChange={(chosen) => {
          service_id.value = chosen;
        }}
      />
      <ol class="trip-calls">
        {calls.value.map((call, number) => (
          <li key={number}>
            <SelectField
              label={t.trip_stop(number + 1)}
              value={call.stop_id}
              options={stops.map(({ stop_id }) => [stop_id, stopName(stop_id)] as const)}
              onChange={(stop_id) => change(number, { stop_id })}
            />
            <TimeField
              label={t.trip_leaves(number + 1)}
              value={call.leaves}
              onChange={(leaves) => change(number, { leaves })}
            />
            {calls.value.length > CALLS_MIN && (
              <button
                type="button"
                class="button small"
                onClick={() => {
                  calls.value = calls.value.filter((_, at) => at !== number);
                }}
              >
                {t.remove_stop(number + 1)}
              </button>
            )}
          </li>
        ))}
      </ol>
      <p class="hint">{t.trip_times_hint}</p>
      <div class="buttons">
        <button
          type="button"
          class="button"
          onClick={() => {
            calls.value = [...calls.value, blank];
          }}
        >
          {t.add_stop}
        </button>
        <button class="button main">{t.keep_trip}</button>
        <button type="button" class="button" onClick={onCancel}>
          {t.cancel}
        </button>
      </div>
    </form>
  );
}

interface TimeFieldProps {
  readonly label: string;
  readonly value: string;
  readonly onChange: (value: string) => void;
}

/** Not of type "time": a trip of the night leaves at 24:30. */
function TimeField({ label, value, onChange }: TimeFieldProps) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <input
        id={id}
        class="input"
        required
        placeholder="08:00"
        pattern="([0-2][0-9]|3[0-5]):[0-5][0-9](:[0-5][0-9])?|36:00"
        value={value}
        onInput={(event) => onChange(event.currentTarget.value)}
      />
    </div>
  );
}
