import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { may } from "../session";
import { refreshService } from "../store/service";
import { texts } from "../texts/texts";
import { formatDate } from "../texts/times";
import type { Pattern } from "./calendar_form";
import { CalendarForm } from "./calendar_form";

const EVERY_DAY = 7;

/** Each service with its days and hours. */
export function CalendarList({ shown }: { readonly shown: Schemas["ServiceView"] }) {
  const t = texts.value;
  const editing = useSignal<Pattern | "new" | null>(null);
  const done = () => {
    editing.value = null;
  };
  return (
    <section class="block card">
      <h2>{t.calendars}</h2>
      <p class="hint">{t.calendars_lead}</p>
      {shown.patterns.length === 0 && <p class="empty">{t.no_calendars}</p>}
      <ul class="rows">
        {shown.patterns.map((pattern) => (
          <li key={pattern.service_id} data-service={pattern.service_id}>
            <PatternRow
              pattern={pattern}
              onEdit={() => {
                editing.value = pattern;
              }}
            />
          </li>
        ))}
      </ul>
      <RoleGate roles={["dispatcher"]}>
        {editing.value === null ? (
          <button
            type="button"
            class="button"
            onClick={() => {
              editing.value = "new";
            }}
          >
            {t.new_calendar}
          </button>
        ) : (
          <CalendarForm
            key={editing.value === "new" ? "" : editing.value.service_id}
            pattern={editing.value === "new" ? null : editing.value}
            onDone={done}
          />
        )}
      </RoleGate>
    </section>
  );
}

interface PatternRowProps {
  readonly pattern: Pattern;
  readonly onEdit: () => void;
}

function PatternRow({ pattern, onEdit }: PatternRowProps) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const remove = async () => {
    const path = { service_id: pattern.service_id };
    const result = await resultOf(
      api.DELETE("/api/v1/service/patterns/{service_id}", { params: { path } }),
    );
    problem.value = result.ok ? null : result.problem;
    await refreshService();
  };
  return (
    <div class="line">
      <span>
        <strong>{pattern.name}</strong> {daysText(pattern)}
        <small>
          {[
            dateRangeText(pattern),
            ...pattern.hours.map((hours) => `${hours.opens}–${hours.closes}`),
            pattern.trips > 0 ? t.trips_of(pattern.trips) : "",
          ]
            .filter((part) => part !== "")
            .join(" · ")}
        </small>
      </span>
      {may("dispatcher") && (
        <span class="buttons">
          <button type="button" class="button small" onClick={onEdit}>
            {t.edit}
          </button>
          {pattern.trips === 0 && (
            <button type="button" class="button small" onClick={() => void remove()}>
              {t.remove}
            </button>
          )}
        </span>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}

function daysText(pattern: Pattern): string {
  if (pattern.weekdays.length === EVERY_DAY) return texts.value.every_day;
  if (pattern.weekdays.length === 0) return texts.value.no_day;
  return pattern.weekdays.map((day) => weekdayName(day, language.value, "short")).join(" ");
}

function dateRangeText(pattern: Pattern): string {
  const t = texts.value;
  const { starts_on, ends_on } = pattern;
  if (starts_on === null && ends_on === null) return "";
  if (ends_on === null) return t.from_day(formatDate(starts_on!));
  if (starts_on === null) return t.until_day(formatDate(ends_on));
  return `${formatDate(starts_on)} – ${formatDate(ends_on)}`;
}
