import type { Scene } from "../../../shared/scene/scene";
import { fragmentOf } from "../../address";
import { stopName } from "../../texts/stop_names";
import { texts } from "../../texts/texts";
import { formatTime } from "../../texts/times";
import { ConditionChip } from "../../vehicles/condition_chip";
import { batteryText } from "../../vehicles/vehicle_status";
import type { FleetPlayer } from "./fleet_player";
import { isAboard, type PastRide } from "./fleet_scene";

interface PastVehiclePanelProps {
  readonly player: FleetPlayer;
  readonly scene: Scene;
  readonly vehicle_id: string;
  readonly onClose: () => void;
}

/** One shuttle at this moment, its riders then, and the recording of what it saw. */
export function PastVehiclePanel({ player, scene, vehicle_id, onClose }: PastVehiclePanelProps) {
  const t = texts.value;
  const vehicle = scene.vehicles.find((each) => each.vehicle_id === vehicle_id);
  const { at_ms } = scene;
  const rides = (player.past.value?.rides ?? []).filter(
    (ride) =>
      ride.vehicle_id === vehicle_id &&
      ride.requested_ms <= at_ms &&
      (ride.ended_ms === 0 || at_ms < ride.ended_ms),
  );
  const run = (player.past.value?.runs ?? []).find(
    (each) => each.vehicle_id === vehicle_id && each.from_ms <= at_ms && at_ms <= each.to_ms,
  );
  return (
    <section class="block vehicle" aria-label={vehicle?.facts.name ?? vehicle_id}>
      <header class="block-head">
        <button type="button" class="button quiet small" onClick={onClose}>
          {t.all_vehicles}
        </button>
      </header>
      <div class="row-head">
        <h2>{vehicle?.facts.name ?? vehicle_id}</h2>
        {vehicle !== undefined && (
          <ConditionChip vehicle={vehicle} knowledge={{ now_ms: at_ms, known_ms: at_ms }} />
        )}
      </div>
      {vehicle?.status != null && (
        <p>
          {t.kmh((3.6 * Math.abs(vehicle.status.speed_mps)).toFixed(1))} ·{" "}
          {batteryText(vehicle.status)}
        </p>
      )}
      {run !== undefined && (
        <a
          class="button"
          href={fragmentOf("runs", vehicle_id, run.boot_id, String(Math.round(at_ms)))}
        >
          {t.what_it_saw}
        </a>
      )}
      <h3>{t.rides}</h3>
      {rides.length === 0 && <p class="empty">{t.no_rides_then}</p>}
      <ul class="plain">
        {rides.map((ride) => (
          <RideLine key={ride.ride_id} ride={ride} at_ms={at_ms} />
        ))}
      </ul>
    </section>
  );
}

function RideLine({ ride, at_ms }: { readonly ride: PastRide; readonly at_ms: number }) {
  const t = texts.value;
  const where = `${stopName(ride.from_stop)} → ${stopName(ride.to_stop)}`;
  const state = isAboard(ride, at_ms)
    ? t.aboard_since(formatTime(ride.boarded_ms))
    : t.not_aboard_yet;
  return (
    <li>
      <strong>{ride.ride_code}</strong> {where}
      <br />
      <span class="hint">
        {state} · {t.people_count(ride.party)}
      </span>
    </li>
  );
}
