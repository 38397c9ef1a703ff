import { useEffect, useMemo } from "preact/hooks";
import { monotonic_ms } from "../../shared/live/clock";
import type { VehicleScene } from "../../shared/scene/scene";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { OnboardView } from "../onboard/onboard_view";
import { live_onboard, OLD_MS, SceneWatch } from "../onboard/shown_scene";
import { withNames } from "../texts/names";
import { texts } from "../texts/texts";

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
      <SceneState watch={watch} connected={vehicle.facts.connected} />
      {scene !== null && <OnboardView scene={scene} />}
    </details>
  );
}

interface SceneStateProps {
  readonly watch: SceneWatch;
  readonly connected: boolean;
}

/** How old it is, or why nothing comes. */
function SceneState({ watch, connected }: SceneStateProps) {
  const t = texts.value;
  // The age grows with the time of this screen.
  void monotonic_ms.value;
  const { value: shown } = watch.shown;
  if (shown === null) return null;
  const { age_ms } = watch;
  const age_s = age_ms === null ? "" : (age_ms / 1000).toFixed(1);
  const is_old = age_ms !== null && age_ms > OLD_MS;
  return (
    <>
      {!connected && <Alert>{t.scene_out_of_reach}</Alert>}
      {connected && shown.request === "failed" && (
        <Alert>{t.scene_refused(withNames(shown.detail))}</Alert>
      )}
      {connected && shown.request === "pending" && <p class="hint">{t.scene_asked}</p>}
      {!watch.watching.value && <p class="hint">{t.scene_over}</p>}
      {age_ms !== null &&
        (is_old ? (
          <Alert tone="warning">{t.scene_is_old(age_s)}</Alert>
        ) : (
          <p class="hint">{t.scene_age(age_s)}</p>
        ))}
    </>
  );
}
