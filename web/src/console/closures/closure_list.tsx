import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import { language } from "../../shared/texts/language";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { closures } from "../store/closures";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { ClosureForm } from "./closure_form";
import { onePerRoad } from "./road_picker";
import { length_m, roadName } from "./roads";

type Closure = Schemas["ClosureView"];

/** Road closures in force and ahead; the operator enters, undoes and lifts them here. */
export function ClosureList() {
  const t = texts.value;
  const entered = useSignal<Closure | null>(null);
  const shown = closures.value.value;
  const last = entered.value;
  const stands = shown?.some((closure) => closure.closure_id === last?.closure_id) === true;
  return (
    <section class="block card closures">
      <h2>{t.closures}</h2>
      <p class="hint">{t.closures_lead}</p>
      <RoleGate roles={["dispatcher"]}>
        <ClosureForm entered={entered} />
      </RoleGate>
      {last !== null && stands && <EnteredNotice closure={last} />}
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

function EnteredNotice({ closure }: { readonly closure: Closure }) {
  const t = texts.value;
  return (
    <Alert tone="good">
      <p>{closure.state === "in_force" ? t.road_closed : t.closure_entered}</p>
      <LiftButton closure={closure} text={t.undo} />
      <p class="hint">{t.undo_closure_hint}</p>
    </Alert>
  );
}

function ClosureRow({ closure }: { readonly closure: Closure }) {
  const t = texts.value;
  return (
    <div class="line">
      <span>
        <strong>{roadNames(closure)}</strong> {closure.reason}
        <small>
          <span class={`chip ${closure.state === "in_force" ? "warning" : "calm"}`}>
            {t.closure_states[closure.state]}
          </span>{" "}
          {closure.state === "scheduled" && `${t.from_time(formatDateTime(closure.starts_at))} `}
          {closure.ends_at === null
            ? t.until_lifted
            : t.until_time(formatDateTime(closure.ends_at))}{" "}
          · {closure.made_by}
        </small>
      </span>
      <RoleGate roles={["dispatcher"]}>
        <LiftButton closure={closure} text={t.lift} />
      </RoleGate>
    </div>
  );
}

function LiftButton({ closure, text }: { readonly closure: Closure; readonly text: string }) {
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
    <>
      <button type="button" class="button small" onClick={() => void lift()}>
        {text}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </>
  );
}

/** The roads by name, each once; sections of a lane count as their road. */
function roadNames(closure: Closure): string {
  const geometry = campus.value?.geometry;
  if (geometry === undefined) return "";
  const named = geometry.lanes.filter(
    (lane) =>
      closure.lane_ids.includes(lane.lane_id) ||
      closure.section_ids.some((section_id) => section_id.startsWith(`${lane.lane_id}/`)),
  );
  const t = texts.value;
  return onePerRoad(named)
    .map((lane) =>
      t.road(
        roadName(lane, geometry.stops, language.value, t.road_near),
        Math.round(length_m(lane)),
      ),
    )
    .join("; ");
}
