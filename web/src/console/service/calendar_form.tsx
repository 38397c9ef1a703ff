import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemAlert } from "../../shared/ui/alerts";
import { formatHours, parseHours } from "../forms/hours_text";
import { TextField } from "../forms/text_field";
import { refreshService } from "../store/service";
import { texts } from "../texts/texts";

export type Pattern = Schemas["PatternView"];

const WEEK = [0, 1, 2, 3, 4, 5, 6];

interface CalendarFormProps {
  /** null for a new calendar. */
  readonly pattern: Pattern | null;
  readonly onDone: () => void;
}

export function CalendarForm({ pattern, onDone }: CalendarFormProps) {
  const t = texts.value;
  const service_id = useSignal(pattern?.service_id ?? "");
  const name = useSignal(pattern?.name ?? "");
  const weekdays = useSignal<readonly number[]>(pattern?.weekdays ?? [0, 1, 2, 3, 4]);
  const starts_on = useSignal(pattern?.starts_on ?? "");
  const ends_on = useSignal(pattern?.ends_on ?? "");
  const hours = useSignal(formatHours(pattern?.hours ?? []));
  const problem = useSignal<Problem | null>(null);
  const toggle = (day: number) => {
    weekdays.value = weekdays.value.includes(day)
      ? weekdays.value.filter((other) => other !== day)
      : [...weekdays.value, day].sort();
  };
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.PUT("/api/v1/service/patterns/{service_id}", {
        params: { path: { service_id: service_id.value } },
        body: {
          name: name.value,
          weekdays: [...weekdays.value],
          starts_on: starts_on.value === "" ? null : starts_on.value,
          ends_on: ends_on.value === "" ? null : ends_on.value,
          hours: parseHours(hours.value),
        },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) onDone();
    await refreshService();
  };
  return (
    <form class="grid-form calendar-form" onSubmit={(event) => void submit(event)}>
      {pattern === null && (
        <TextField
          label={t.service_id}
          value={service_id}
          hint={t.id_hint}
          input={{
            required: true,
            pattern: "[A-Za-z0-9][A-Za-z0-9._@:\\-]{0,63}",
            autocomplete: "off",
          }}
        />
      )}
      <TextField label={t.calendar_name} value={name} input={{ required: true, maxLength: 200 }} />
      <fieldset class="days-of-week">
        <legend>{t.weekdays}</legend>
        {WEEK.map((day) => (
          <label key={day} class="check">
            <input
              type="checkbox"
              checked={weekdays.value.includes(day)}
              onChange={() => toggle(day)}
            />
            {weekdayName(day, language.value, "short")}
          </label>
        ))}
      </fieldset>
      <TextField label={t.first_day} value={starts_on} input={{ type: "date" }} />
      <TextField label={t.last_day} value={ends_on} input={{ type: "date" }} />
      <TextField
        label={t.hours}
        value={hours}
        hint={t.hours_hint}
        input={{
          pattern: "\\s*(\\d\\d:\\d\\d\\s*-\\s*\\d\\d:\\d\\d\\s*(,\\s*|$))*",
          placeholder: "07:30-12:00, 13:30-22:00",
        }}
      />
      <div class="buttons">
        <button class="button main">{t.save}</button>
        <button type="button" class="button" onClick={onDone}>
          {t.cancel}
        </button>
      </div>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}
