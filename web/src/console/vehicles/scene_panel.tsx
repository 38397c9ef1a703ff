import { useEffect, useMemo } from "preact/hooks";
import type { VehicleScene } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { OnboardView } from "../onboard/onboard_view";
import { live_onboard, SceneWatch } from "../onboard/shown_scene";
import { texts } from "../texts/texts";
import { RequestState } from "./request_state";

/** What the shuttle sees now, for a minute at a time: an operator has to ask for it. */
export function ScenePanel({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { vehicle_id } = vehicle;
  const watch = useMemo(() => new SceneWatch(vehicle_id), [vehicle_id]);
  useEffect(() => {
    live_onboard.value = watch;
    return () => {
      watch.close();
      if (live_onboard.value === watch) live_onboard.value = null;
    };
  }, [watch]);
  const scene = watch.shown.value?.scene ?? null;
  return (
    <details class="shifts recording">
      <summary>{t.onboard}</summary>
      <p class="hint">{t.show_scene_hint}</p>
      <RoleGate roles={["dispatcher", "safety"]}>
        <button type="button" class="button small" onClick={() => void watch.ask()}>
          {watch.watching.value ? t.show_scene_again : t.show_scene}
        </button>
      </RoleGate>
      {watch.problem.value !== null && <ProblemAlert problem={watch.problem.value} />}
      <RequestState watch={watch} connected={vehicle.facts.connected} />
      {scene !== null && <OnboardView scene={scene} />}
    </details>
  );
}
