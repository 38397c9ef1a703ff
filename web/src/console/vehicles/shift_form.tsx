import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemAlert } from "../../shared/ui/alerts";
import { formatHours, parseHours } from "../forms/hours_text";
import { texts } from "../texts/texts";

type Shifts = Schemas["ShiftsModel"];

const WEEK = [0, 1, 2, 3, 4, 5, 6];

/** When a shuttle is on duty: one line of hours for each weekday. Exceptions for single days stay as they are. */
export function ShiftForm({ vehicle_id }: { readonly vehicle_id: string }) {
  const t = texts.value;
  const stored = useSignal<Shifts | null>(null);
  const lines = useSignal<readonly string[]>(WEEK.map(() => ""));
  const always_on_duty = useSignal(true);
  const problem = useSignal<Problem | null>(null);
  const saved = useSignal(false);
  const path = { params: { path: { vehicle_id } } };
  useEffect(() => {
    void resultOf(api.GET("/api/v1/vehicles/{vehicle_id}/shifts", path)).then((result) => {
      problem.value = result.ok ? null : result.problem;
      if (!result.ok) return;
      stored.value = result.value;
      always_on_duty.value = result.value === null;
      if (result.value !== null) lines.value = result.value.weekly.map(shiftsText);
    });
  }, [vehicle_id]);
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await (always_on_duty.value
      ? resultOf(api.DELETE("/api/v1/vehicles/{vehicle_id}/shifts", path))
      : resultOf(
          api.PUT("/api/v1/vehicles/{vehicle_id}/shifts", {
            ...path,
            body: {
              weekly: lines.value.map(parseShifts),
              exceptions: stored.value?.exceptions ?? [],
            },
          }),
        ));
    problem.value = result.ok ? null : result.problem;
    saved.value = result.ok;
  };
  return (
    <details class="shifts">
      <summary>{t.shifts}</summary>
      <form class="grid-form" onSubmit={(event) => void submit(event)}>
        <label class="check">
          <input
            type="checkbox"
            checked={always_on_duty.value}
            onChange={(event) => {
              always_on_duty.value = event.currentTarget.checked;
            }}
          />
          {t.always_on_duty}
        </label>
        {!always_on_duty.value &&
          WEEK.map((day) => (
            <label key={day} class="field">
              {weekdayName(day, language.value, "short")}
              <input
                class="input"
                value={lines.value[day]}
                placeholder={t.day_off}
                onInput={(event) => {
                  const text = event.currentTarget.value;
                  lines.value = lines.value.map((line, other) => (other === day ? text : line));
                }}
              />
            </label>
          ))}
        <p class="hint">{t.shifts_hint}</p>
        <button class="button">{t.save}</button>
        {saved.value && <p class="hint">{t.shifts_saved}</p>}
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
      </form>
    </details>
  );
}

function shiftsText(shifts: Shifts["weekly"][number]): string {
  return formatHours(shifts.map(({ begins, ends }) => ({ opens: begins, closes: ends })));
}

function parseShifts(line: string): Shifts["weekly"][number] {
  return parseHours(line).map(({ opens, closes }) => ({ begins: opens, ends: closes }));
}
