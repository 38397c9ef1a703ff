import { conditionOf, urgencyOf } from "../../shared/scene/condition";
import type { VehicleScene } from "../../shared/scene/scene";
import { words } from "../texts/words";

/** State in a word; the colour only repeats it. */
export function ConditionChip({ vehicle }: { readonly vehicle: VehicleScene }) {
  const condition = conditionOf(vehicle);
  return <span class={`chip ${urgencyOf(condition)}`}>{words.value.conditions[condition]}</span>;
}
