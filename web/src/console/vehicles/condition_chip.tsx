import { conditionOf, urgencyOf } from "../../shared/scene/condition";
import type { VehicleScene } from "../../shared/scene/scene";
import { texts } from "../texts/texts";

/** A shuttle's condition as text; the colour repeats it. */
export function ConditionChip({ vehicle }: { readonly vehicle: VehicleScene }) {
  const condition = conditionOf(vehicle);
  return <span class={`chip ${urgencyOf(condition)}`}>{texts.value.conditions[condition]}</span>;
}
