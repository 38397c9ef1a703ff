import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import { fromLocalInput } from "../../shared/texts/times";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { TextField } from "../forms/text_field";
import { closures } from "../store/closures";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";

type Closure = Schemas["ClosureView"];

/** Road closures in force and ahead; the operator enters and lifts them here. */
export function ClosureList() {
  const t = texts.value;
  const shown = closures.value.value;
  return (
    <section class="block card">
      <h2>{t.closures}</h2>
      <p class="hint">{t.closures_lead}</p>
      <RoleGate roles={["dispatcher"]}>
        <ClosureForm />
      </RoleGate>
      {closures.problem.value !== null && <ProblemAlert problem={closures.problem.value} />}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_closures}</p>}
      <ul class="rows">
        {(shown ?? []).map((closure) => (
          <li key={closure.closure_id} data-closure={closure.closure_id}>
            <ClosureRow closure={closure} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function ClosureForm() {
  const t = texts.value;
  const [lanes, reason] = [useSignal(""), useSignal("")];
  const [from, until] = [useSignal(""), useSignal("")];
  const problem = useSignal<Problem | null>(null);
  const known = useId();
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.POST("/api/v1/closures", {
        body: {
          lane_ids: lanes.value.split(/[\s,]+/).filter(Boolean),
          section_ids: [],
          reason: reason.value,
          starts_at: isoTime(from.value),
          ends_at: isoTime(until.value),
        },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) for (const field of [lanes, reason, from, until]) field.value = "";
    await closures.refresh();
  };
  return (
    <form class="grid-form" onSubmit={(event) => void submit(event)}>
      <TextField
        label={t.closure_lanes}
        value={lanes}
        hint={t.closure_lanes_hint}
        input={{ required: true, list: known }}
      />
      <datalist id={known}>
        {(campus.value?.geometry.lanes ?? []).map((lane) => (
          <option key={lane.lane_id} value={lane.lane_id} />
        ))}
      </datalist>
      <TextField label={t.closure_reason} value={reason} input={{ maxLength: 200 }} />
      <TextField label={t.closure_from} value={from} input={{ type: "datetime-local" }} />
      <TextField label={t.closure_until} value={until} input={{ type: "datetime-local" }} />
      <button class="button main">{t.close_road}</button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </form>
  );
}

/** The time of a field in the campus's timezone; null for an empty field. */
function isoTime(local: string): string | null {
  return fromLocalInput(local, campus.value?.view.timezone ?? "UTC")?.toISOString() ?? null;
}

function ClosureRow({ closure }: { readonly closure: Closure }) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const lift = async () => {
    const result = await resultOf(
      api.DELETE("/api/v1/closures/{closure_id}", {
        params: { path: { closure_id: closure.closure_id } },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    await closures.refresh();
  };
  return (
    <div class="line">
      <span>
        <strong>{[...closure.lane_ids, ...closure.section_ids].join(" ")}</strong> {closure.reason}
        <small>
          <span class={`chip ${closure.state === "in_force" ? "warning" : "calm"}`}>
            {t.closure_states[closure.state]}
          </span>{" "}
          {closure.state === "scheduled" && `${t.from_time(formatDateTime(closure.starts_at))} `}
          {closure.ends_at === null
            ? t.until_lifted
            : t.until_time(formatDateTime(closure.ends_at))}{" "}
          {closure.made_by}
        </small>
      </span>
      <button type="button" class="button small" onClick={() => void lift()}>
        {t.lift}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}
