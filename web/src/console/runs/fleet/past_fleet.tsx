import type { Scene } from "../../../shared/scene/scene";
import { inNaturalOrder } from "../../fleet/fleet_order";
import { VirtualRows } from "../../fleet/virtual_rows";
import { texts } from "../../texts/texts";
import { ConditionChip } from "../../vehicles/condition_chip";

interface PastFleetProps {
  readonly scene: Scene;
  readonly onSelect: (vehicle_id: string) => void;
}

/** The shuttles as they were at this moment. */
export function PastFleet({ scene, onSelect }: PastFleetProps) {
  const t = texts.value;
  const knowledge = { now_ms: scene.at_ms, known_ms: scene.at_ms };
  return (
    <section class="block" aria-label={t.vehicles}>
      <h2>{t.vehicles}</h2>
      <VirtualRows items={inNaturalOrder(scene.vehicles)} keyOf={(vehicle) => vehicle.vehicle_id}>
        {(vehicle) => (
          <button type="button" class="row" onClick={() => onSelect(vehicle.vehicle_id)}>
            <span class="row-head">
              <strong>{vehicle.facts.name}</strong>
              <ConditionChip vehicle={vehicle} knowledge={knowledge} />
            </span>
            {vehicle.task.people_aboard > 0 && (
              <span class="hint">{t.people_count(vehicle.task.people_aboard)}</span>
            )}
          </button>
        )}
      </VirtualRows>
    </section>
  );
}
