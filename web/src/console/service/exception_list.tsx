import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { TextField } from "../forms/text_field";
import { refreshService } from "../store/service";
import { texts } from "../texts/texts";
import { formatDate } from "../texts/times";

type Service = Schemas["ServiceView"];
type Exception = Schemas["ExceptionView"];

/** Holidays of the campus, and exceptions of one service for single days. */
export function ExceptionList({ shown }: { readonly shown: Service }) {
  const t = texts.value;
  return (
    <section class="block card">
      <h2>{t.exceptions}</h2>
      <p class="hint">{t.exceptions_lead}</p>
      <RoleGate roles={["dispatcher"]}>
        <ExceptionForm shown={shown} />
      </RoleGate>
      {shown.exceptions.length === 0 && <p class="empty">{t.no_exceptions}</p>}
      <ul class="rows">
        {shown.exceptions.map((exception) => (
          <li key={`${exception.day} ${exception.service_id}`} data-exception={exception.day}>
            <ExceptionRow exception={exception} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function ExceptionForm({ shown }: { readonly shown: Service }) {
  const t = texts.value;
  const [day, note] = [useSignal(""), useSignal("")];
  const service_id = useSignal("");
  const runs = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const id = useId();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.PUT("/api/v1/service/exceptions/{day}", {
        params: { path: { day: day.value } },
        body: {
          service_id: service_id.value,
          runs: service_id.value !== "" && runs.value,
          note: note.value,
        },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) note.value = "";
    await refreshService();
  };
  return (
    <form class="grid-form" onSubmit={(event) => void submit(event)}>
      <TextField label={t.day} value={day} input={{ type: "date", required: true }} />
      <TextField label={t.exception_note} value={note} input={{ maxLength: 200 }} />
      <div class="field">
        <label for={id}>{t.exception_scope}</label>
        <select
          id={id}
          class="input"
          value={service_id.value}
          onChange={(event) => {
            service_id.value = event.currentTarget.value;
          }}
        >
          <option value="">{t.whole_campus}</option>
          {shown.patterns.map((pattern) => (
            <option key={pattern.service_id} value={pattern.service_id}>
              {pattern.name}
            </option>
          ))}
        </select>
      </div>
      {service_id.value !== "" && (
        <label class="check">
          <input
            type="checkbox"
            checked={runs.value}
            onChange={(event) => {
              runs.value = event.currentTarget.checked;
            }}
          />
          {t.runs_anyway}
        </label>
      )}
      <button class="button main">{t.add_day}</button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}

function ExceptionRow({ exception }: { readonly exception: Exception }) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const remove = async () => {
    const result = await resultOf(
      api.DELETE("/api/v1/service/exceptions/{day}", {
        params: {
          path: { day: exception.day },
          query: { service_id: exception.service_id },
        },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    await refreshService();
  };
  return (
    <div class="line">
      <span>
        <strong>{formatDate(exception.day)}</strong> {exception.note}
        <small>
          <span class={`chip ${exception.runs ? "good" : "warning"}`}>
            {exception.service_id === ""
              ? t.holiday
              : exception.runs
                ? t.service_runs(exception.service_id)
                : t.service_rests(exception.service_id)}
          </span>{" "}
          {exception.made_by}
        </small>
      </span>
      <button type="button" class="button small" onClick={() => void remove()}>
        {t.remove}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}
