import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { VehicleScene } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { texts } from "../texts/texts";
import { beginChoice, endChoice, poseOf, position_choice } from "./position_choice";

/** An operator tells a standing shuttle where it is: two clicks on the map, then a confirmation. */
export function PositionPanel({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { vehicle_id } = vehicle;
  const problem = useSignal<Problem | null>(null);
  const is_sending = useSignal(false);
  const is_sent = useSignal(false);
  useEffect(() => endChoice, [vehicle_id]);
  const choice = position_choice.value;
  const pose = choice === null ? null : poseOf(choice);
  const begin = () => {
    problem.value = null;
    is_sent.value = false;
    beginChoice(vehicle_id);
  };
  const confirm = async () => {
    if (pose === null) return;
    is_sending.value = true;
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/position", {
        params: { path: { vehicle_id } },
        body: { ...pose },
      }),
    );
    is_sending.value = false;
    problem.value = result.ok ? null : result.problem;
    is_sent.value = result.ok;
    if (result.ok) endChoice();
  };
  return (
    <RoleGate roles={["safety"]}>
      <details class="shifts recording">
        <summary>{t.named_position}</summary>
        <p class="hint">{t.named_position_hint}</p>
        {choice === null ? (
          <button type="button" class="button small" onClick={begin}>
            {t.name_position}
          </button>
        ) : (
          <>
            <p role="status">
              {choice.at === null
                ? t.click_place
                : pose === null
                  ? t.click_direction
                  : t.position_chosen(pose.x_m.toFixed(1), pose.y_m.toFixed(1))}
            </p>
            <button
              type="button"
              class="button small main"
              disabled={pose === null || is_sending.value}
              onClick={() => void confirm()}
            >
              {t.confirm_position}
            </button>{" "}
            <button type="button" class="button small" onClick={endChoice}>
              {t.cancel}
            </button>
          </>
        )}
        {is_sent.value && <p role="status">{t.position_sent}</p>}
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
      </details>
    </RoleGate>
  );
}
