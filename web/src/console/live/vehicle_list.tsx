import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { goTo } from "../navigation";
import { is_stale } from "../session";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { batteryText } from "../vehicles/vehicle_status";
import { ConditionChip } from "../vehicles/condition_chip";

export function VehicleList({ scene }: { readonly scene: Scene }) {
  const t = texts.value;
  const vehicles = [...scene.vehicles].sort((a, b) => a.facts.name.localeCompare(b.facts.name));
  return (
    <section class="block" aria-label={t.vehicles}>
      <h2>{t.vehicles}</h2>
      {vehicles.length === 0 && (
        <p class="empty">
          {t.no_vehicles}{" "}
          <button type="button" class="button small" onClick={() => goTo("access")}>
            {t.enrol_first}
          </button>
        </p>
      )}
      <ul class="rows">
        {vehicles.map((vehicle) => (
          <li key={vehicle.vehicle_id}>
            <VehicleRow vehicle={vehicle} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function VehicleRow({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { facts, status, task } = vehicle;
  return (
    <button type="button" class="row" onClick={() => goTo("live", vehicle.vehicle_id)}>
      <span class="row-head">
        <strong>{facts.name}</strong>
        <ConditionChip vehicle={vehicle} stale={is_stale.value} />
      </span>
      <span class="row-facts">
        {!facts.in_service && <span>{t.out_of_service}</span>}
        {status !== null && !is_stale.value && (
          <span>{t.kmh((status.speed_mps * 3.6).toFixed(0))}</span>
        )}
        <span>{t.seats_taken(task.people_aboard, facts.seats)}</span>
        {status !== null && (
          <span>{status.battery_ratio > 0 ? batteryText(status) : t.battery_unknown}</span>
        )}
        {task.next_stop !== "" && <span>→ {stopName(task.next_stop)}</span>}
      </span>
    </button>
  );
}
