import { useEffect, useId, useRef } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { serverNow_ms } from "../../shared/api/server_time";
import { language } from "../../shared/texts/language";
import { fromLocalInput, toLocalInput, weekdayName } from "../../shared/texts/times";
import { texts } from "../texts/texts";
import { earliest } from "./ride_request";
import {
  DAYS_MAX,
  dateInDays,
  ends_on,
  isRecurring,
  leave_time,
  makeRecurring,
  toggleWeekday,
  weekdays,
} from "./series_request";

/** What is mostly meant by "later". */
const SOON_MIN = [15, 30, 60];
const DEFAULT_DELAY_MS = 15 * 60_000;
const PAST_MS_MAX = 60_000;
const WEEK = [0, 1, 2, 3, 4, 5, 6];

interface CampusViewProps {
  readonly view: Schemas["CampusView"];
}

/** Whether the pickup time is "now" or lies ahead. */
export function isPickupTimeValid(timezone: string): boolean {
  if (earliest.value === "") return true;
  const time = fromLocalInput(earliest.value, timezone);
  return time !== null && time.getTime() > serverNow_ms() - PAST_MS_MAX;
}

/** The pickup time: now, a later time in the campus's timezone, or a time on certain weekdays. */
export function PickupTimeField({ view }: CampusViewProps) {
  const t = texts.value;
  const is_later = !isRecurring.value && earliest.value !== "";
  const choose = (time: string) => {
    isRecurring.value = false;
    earliest.value = time;
  };
  return (
    <fieldset class="pickup-time">
      <legend>{t.when}</legend>
      <div class="switch">
        <button
          type="button"
          aria-pressed={!is_later && !isRecurring.value}
          onClick={() => choose("")}
        >
          {t.now}
        </button>
        <button
          type="button"
          aria-pressed={is_later}
          onClick={() =>
            choose(earliest.value || toLocalInput(serverNow_ms() + DEFAULT_DELAY_MS, view.timezone))
          }
        >
          {t.later}
        </button>
        <button
          type="button"
          aria-pressed={isRecurring.value}
          onClick={() => makeRecurring(view.timezone)}
        >
          {t.repeat}
        </button>
      </div>
      {is_later && <LaterTimeField view={view} />}
      {isRecurring.value && <RecurrenceFields view={view} />}
    </fieldset>
  );
}

function LaterTimeField({ view }: CampusViewProps) {
  const id = useId();
  const t = texts.value;
  const field = useRef<HTMLDivElement>(null);
  const input = (time_ms: number) => toLocalInput(time_ms, view.timezone);
  // On a phone the field would appear behind the bar with the button.
  useEffect(() => field.current?.scrollIntoView({ block: "center" }), []);
  return (
    <div class="field" ref={field}>
      <div class="soon">
        {SOON_MIN.map((minutes) => (
          <button
            key={minutes}
            type="button"
            class="button small"
            onClick={() => {
              earliest.value = input(serverNow_ms() + minutes * 60_000);
            }}
          >
            {t.in_min(minutes)}
          </button>
        ))}
      </div>
      <label for={id}>{t.earliest_pickup}</label>
      <input
        id={id}
        class="input"
        type="datetime-local"
        required
        min={input(serverNow_ms())}
        max={input(serverNow_ms() + view.booking_ahead_s_max * 1000)}
        value={earliest.value}
        onChange={(event) => {
          const time = event.currentTarget.value;
          if (time !== "") earliest.value = time;
        }}
      />
      {!isPickupTimeValid(view.timezone) && (
        <p class="field-error" role="alert">
          {t.time_invalid}
        </p>
      )}
    </div>
  );
}

function RecurrenceFields({ view }: CampusViewProps) {
  const [time_id, day_id] = [useId(), useId()];
  const fields = useRef<HTMLDivElement>(null);
  const t = texts.value;
  // On a phone the fields would appear behind the bar with the button.
  useEffect(() => fields.current?.scrollIntoView({ block: "center" }), []);
  return (
    <div class="recurrence" ref={fields}>
      <div class="weekdays" role="group" aria-label={t.weekdays}>
        {WEEK.map((day) => (
          <button
            key={day}
            type="button"
            aria-pressed={weekdays.value.includes(day)}
            aria-label={dayLabel(day)}
            onClick={() => toggleWeekday(day)}
          >
            {weekdayName(day, language.value, "short")}
          </button>
        ))}
      </div>
      {weekdays.value.length === 0 && (
        <p class="field-error" role="alert">
          {t.weekdays_none}
        </p>
      )}
      <div class="field-pair even">
        <div class="field">
          <label for={time_id}>{t.repeat_leave}</label>
          <input
            id={time_id}
            class="input"
            type="time"
            required
            value={leave_time.value}
            onChange={(event) => {
              const time = event.currentTarget.value.slice(0, 5);
              if (time !== "") leave_time.value = time;
            }}
          />
        </div>
        <div class="field">
          <label for={day_id}>{t.repeat_until}</label>
          <input
            id={day_id}
            class="input"
            type="date"
            required
            min={dateInDays(0, view.timezone)}
            max={dateInDays(DAYS_MAX, view.timezone)}
            value={ends_on.value}
            onChange={(event) => {
              const date = event.currentTarget.value;
              if (date !== "") ends_on.value = date;
            }}
          />
        </div>
      </div>
      <p class="hint">{t.repeat_hint}</p>
    </div>
  );
}

/** What is written on the button belongs to its spoken name: who speaks to the phone says what they see. */
function dayLabel(day: number): string {
  const [short, long] = (["short", "long"] as const).map((width) =>
    weekdayName(day, language.value, width),
  );
  return `${short}, ${long}`;
}
