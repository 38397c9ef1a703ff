import { useEffect, useId, useRef } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { language } from "../../shared/texts/language";
import { fromLocalInput, toLocalInput, weekdayName } from "../../shared/texts/times";
import { texts } from "../texts/texts";
import { earliest } from "./ride_request";
import {
  DAYS_MAX,
  dayAfter,
  ends_on,
  leave,
  repeating,
  startRepeating,
  toggleWeekday,
  weekdays,
} from "./series_request";

const FIRST_CHOICE_MS = 15 * 60_000;
const PAST_MS_MAX = 60_000;
const WEEK = [0, 1, 2, 3, 4, 5, 6];

interface ViewProps {
  readonly view: Schemas["CampusView"];
}

/** Now, or a time that is not over. */
export function timeIsUsable(timezone: string): boolean {
  if (earliest.value === "") return true;
  const chosen = fromLocalInput(earliest.value, timezone);
  return chosen !== null && chosen.getTime() > Date.now() - PAST_MS_MAX;
}

/** "Now", a time on the campus's clocks, or certain weekdays at one time. */
export function WhenField({ view }: ViewProps) {
  const t = texts.value;
  const is_later = !repeating.value && earliest.value !== "";
  const choose = (moment: string) => {
    repeating.value = false;
    earliest.value = moment;
  };
  return (
    <fieldset class="when">
      <legend>{t.when}</legend>
      <div class="switch">
        <button
          type="button"
          aria-pressed={!is_later && !repeating.value}
          onClick={() => choose("")}
        >
          {t.now}
        </button>
        <button
          type="button"
          aria-pressed={is_later}
          onClick={() =>
            choose(earliest.value || toLocalInput(Date.now() + FIRST_CHOICE_MS, view.timezone))
          }
        >
          {t.later}
        </button>
        <button
          type="button"
          aria-pressed={repeating.value}
          onClick={() => startRepeating(view.timezone)}
        >
          {t.repeat}
        </button>
      </div>
      {is_later && <LaterField view={view} />}
      {repeating.value && <RepeatFields view={view} />}
    </fieldset>
  );
}

function LaterField({ view }: ViewProps) {
  const id = useId();
  const t = texts.value;
  const input = (moment_ms: number) => toLocalInput(moment_ms, view.timezone);
  return (
    <div class="field">
      <label for={id}>{t.earliest_pickup}</label>
      <input
        id={id}
        class="input"
        type="datetime-local"
        required
        min={input(Date.now())}
        max={input(Date.now() + view.booking_ahead_s_max * 1000)}
        value={earliest.value}
        onChange={(event) => {
          const chosen = event.currentTarget.value;
          if (chosen !== "") earliest.value = chosen;
        }}
      />
      {!timeIsUsable(view.timezone) && (
        <p class="wrong" role="alert">
          {t.time_invalid}
        </p>
      )}
    </div>
  );
}

function RepeatFields({ view }: ViewProps) {
  const [time_id, day_id] = [useId(), useId()];
  const fields = useRef<HTMLDivElement>(null);
  const t = texts.value;
  // On a phone they would come up behind the bar with the button.
  useEffect(() => fields.current?.scrollIntoView({ block: "center" }), []);
  return (
    <div class="repeat" ref={fields}>
      <div class="weekdays" role="group" aria-label={t.weekdays}>
        {WEEK.map((day) => (
          <button
            key={day}
            type="button"
            aria-pressed={weekdays.value.includes(day)}
            aria-label={weekdayName(day, language.value, "long")}
            onClick={() => toggleWeekday(day)}
          >
            {weekdayName(day, language.value, "short")}
          </button>
        ))}
      </div>
      {weekdays.value.length === 0 && (
        <p class="wrong" role="alert">
          {t.weekdays_none}
        </p>
      )}
      <div class="two even">
        <div class="field">
          <label for={time_id}>{t.repeat_leave}</label>
          <input
            id={time_id}
            class="input"
            type="time"
            required
            value={leave.value}
            onChange={(event) => {
              const chosen = event.currentTarget.value.slice(0, 5);
              if (chosen !== "") leave.value = chosen;
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
            min={dayAfter(0, view.timezone)}
            max={dayAfter(DAYS_MAX, view.timezone)}
            value={ends_on.value}
            onChange={(event) => {
              const chosen = event.currentTarget.value;
              if (chosen !== "") ends_on.value = chosen;
            }}
          />
        </div>
      </div>
      <p class="hint">{t.repeat_hint}</p>
    </div>
  );
}
