import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemNote } from "../../shared/ui/alerts";
import { hoursFrom, hoursText } from "../forms/hours_text";
import { texts } from "../texts/texts";

type Shifts = Schemas["ShiftsModel"];

const WEEK = [0, 1, 2, 3, 4, 5, 6];

/** When a shuttle is on duty: one line of hours for each weekday; days that differ are kept as they are. */
export function ShiftForm({ vehicle_id }: { readonly vehicle_id: string }) {
  const t = texts.value;
  const known = useSignal<Shifts | null>(null);
  const lines = useSignal<readonly string[]>(WEEK.map(() => ""));
  const always = useSignal(true);
  const problem = useSignal<Problem | null>(null);
  const saved = useSignal(false);
  const path = { params: { path: { vehicle_id } } };
  useEffect(() => {
    void answerOf(api.GET("/api/v1/vehicles/{vehicle_id}/shifts", path)).then((answer) => {
      problem.value = answer.ok ? null : answer.problem;
      if (!answer.ok) return;
      known.value = answer.value;
      always.value = answer.value === null;
      if (answer.value !== null) lines.value = answer.value.weekly.map(lineOf);
    });
  }, [vehicle_id]);
  const submit = async (event: Event) => {
    event.preventDefault();
    const answer = await (always.value
      ? answerOf(api.DELETE("/api/v1/vehicles/{vehicle_id}/shifts", path))
      : answerOf(
          api.PUT("/api/v1/vehicles/{vehicle_id}/shifts", {
            ...path,
            body: {
              weekly: lines.value.map(shiftsFrom),
              exceptions: known.value?.exceptions ?? [],
            },
          }),
        ));
    problem.value = answer.ok ? null : answer.problem;
    saved.value = answer.ok;
  };
  return (
    <details class="shifts">
      <summary>{t.shifts}</summary>
      <form class="grid-form" onSubmit={(event) => void submit(event)}>
        <label class="check">
          <input
            type="checkbox"
            checked={always.value}
            onChange={(event) => {
              always.value = event.currentTarget.checked;
            }}
          />
          {t.always_on_duty}
        </label>
        {!always.value &&
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
        {problem.value !== null && <ProblemNote problem={problem.value} />}
      </form>
    </details>
  );
}

function lineOf(shifts: Shifts["weekly"][number]): string {
  return hoursText(shifts.map(({ begins, ends }) => ({ opens: begins, closes: ends })));
}

function shiftsFrom(line: string): Shifts["weekly"][number] {
  return hoursFrom(line).map(({ opens, closes }) => ({ begins: opens, ends: closes }));
}
