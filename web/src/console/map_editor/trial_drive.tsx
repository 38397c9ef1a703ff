import type { Signal } from "@preact/signals";
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { pointsOf, stopName } from "../../shared/campus/campus_geometry";
import type { Point } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { SelectField } from "../forms/select_field";
import { texts } from "../texts/texts";
import type { EditorState } from "./editor_state";
import { MapProblemAlert } from "./map_problem_alert";

interface TrialDriveProps {
  readonly state: EditorState;
  readonly line: Signal<readonly Point[]>;
}

/** The way between two stops and its time; asked again after every step of drawing. */
export function TrialDrive({ state, line }: TrialDriveProps) {
  const t = texts.value;
  const [from, to] = [useSignal(""), useSignal("")];
  const driven = useSignal<Schemas["TrialDrive"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const { stops } = state.elements.value;
  const revision = state.draft.value?.revision;
  useEffect(() => {
    driven.value = null;
    problem.value = null;
    line.value = [];
    if (from.value === "" || to.value === "") return;
    let is_newest = true;
    void resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}/trial-drives", {
        params: {
          path: { draft_id: state.draft_id },
          query: { from_stop: from.value, to_stop: to.value },
        },
      }),
    ).then((result) => {
      if (!is_newest) return;
      driven.value = result.ok ? result.value : null;
      problem.value = result.ok ? null : result.problem;
      line.value = result.ok ? pointsOf(result.value.xy) : [];
    });
    return () => {
      is_newest = false;
    };
  }, [from.value, to.value, revision]);
  const options: [string, string][] = [
    ["", t.choose_stop],
    ...stops.map((stop): [string, string] => [
      stop.stop_id,
      stopName(
        { ...stop, name_en: stop.name_en ?? "", placed_by: "", x_m: 0, y_m: 0 },
        language.value,
      ),
    ]),
  ];
  return (
    <section class="block card">
      <h2>{t.trial_drive}</h2>
      <SelectField
        label={t.from_stop}
        value={from.value}
        options={options}
        onChange={(value) => (from.value = value)}
      />
      <SelectField
        label={t.to_stop}
        value={to.value}
        options={options}
        onChange={(value) => (to.value = value)}
      />
      {driven.value !== null && (
        <p role="status" class="trial-time">
          {t.trial_time(driven.value.time_s, Math.round(driven.value.length_m))}
        </p>
      )}
      {problem.value !== null && <MapProblemAlert problem={problem.value} />}
    </section>
  );
}
