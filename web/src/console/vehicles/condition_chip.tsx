import { conditionOf, urgencyOf } from "../../shared/scene/condition";
import type { VehicleScene } from "../../shared/scene/scene";
import type { Knowledge } from "../../shared/state/knowledge";
import { vehicleState } from "../../shared/state/vehicle_state";
import { texts } from "../texts/texts";

interface ConditionChipProps {
  readonly vehicle: VehicleScene;
  /** Of the scene that it is shown with: live, or at a time of a replay. */
  readonly knowledge: Knowledge;
}

/** A shuttle's condition as text; the colour repeats it. Without news it is unknown. */
export function ConditionChip({ vehicle, knowledge }: ConditionChipProps) {
  const t = texts.value;
  const condition = conditionOf(vehicle);
  // A shuttle out of reach has a name of its own: the server knows of it.
  if (vehicleState(vehicle, knowledge).kind === "unknown" && condition !== "offline")
    return <span class="chip calm">{t.condition_unknown}</span>;
  return <span class={`chip ${urgencyOf(condition)}`}>{t.conditions[condition]}</span>;
}
