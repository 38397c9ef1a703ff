import { conditionOf, urgencyOf } from "../../shared/scene/condition";
import type { VehicleScene } from "../../shared/scene/scene";
import { texts } from "../texts/texts";

interface ConditionChipProps {
  readonly vehicle: VehicleScene;
  /** Nothing was heard for a while: nobody knows the condition. */
  readonly stale?: boolean;
}

/** A shuttle's condition as text; the colour repeats it. */
export function ConditionChip({ vehicle, stale = false }: ConditionChipProps) {
  if (stale) return <span class="chip calm">{texts.value.condition_unknown}</span>;
  const condition = conditionOf(vehicle);
  return <span class={`chip ${urgencyOf(condition)}`}>{texts.value.conditions[condition]}</span>;
}
