import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { HmiOutput } from "./hmi_output";
import { ObservationAreaList } from "./observation_area_list";

const SECTION = "section ";

interface VehicleStatusProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  /** The server's clock at the scene; in a replay it lies in the past. */
  readonly now_ms: number;
}

/** What a scene, live or replayed, says of one shuttle. */
export function VehicleStatus({ vehicle, scene, now_ms }: VehicleStatusProps) {
  const t = texts.value;
  const age_s = Math.max(0, Math.round((now_ms - vehicle.heard_ms) / 1000));
  const aboard = vehicle.aboard.map(
    (ride_id) => scene.rides.find((ride) => ride.ride_id === ride_id)?.ride_code ?? ride_id,
  );
  const next = vehicle.next_stop === "" ? t.to_resting_place : stopName(vehicle.next_stop);
  const facts: readonly (readonly [string, string])[] = [
    [t.speed, t.kmh((vehicle.speed_mps * 3.6).toFixed(1))],
    [t.mode, t.modes[vehicle.mode] ?? vehicle.mode],
    [t.battery, `${(vehicle.battery_ratio * 100).toFixed(0)} %`],
    [t.last_heard, vehicle.heard_ms === 0 ? t.never : t.ago(age_s)],
    [t.doors, vehicle.doors_open ? t.doors_open : t.doors_closed],
    [t.next_stop, next],
    [t.aboard, [t.seats_taken(vehicle.people_aboard, vehicle.seats), ...aboard].join(" · ")],
    [t.obstacle, vehicle.obstacle_m === null ? t.none : t.metres(vehicle.obstacle_m.toFixed(1))],
    [t.limited_by, speedLimitText(vehicle)],
    [t.waits_for_section, vehicle.waiting_for || t.none],
  ];
  return (
    <>
      <HmiOutput screen={vehicle.screen} spoken={vehicle.spoken} />
      <dl class="facts">
        {facts.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
        <div class="long">
          <dt>{t.order}</dt>
          <dd>{vehicle.order_id || t.none}</dd>
        </div>
      </dl>
      <ObservationAreaList vehicle={vehicle} scene={scene} now_ms={now_ms} />
      {vehicle.faults.length > 0 && (
        <div class="alert danger">
          <div>
            <strong>{t.faults}</strong>
            <p>{vehicle.faults.join(", ")}</p>
          </div>
        </div>
      )}
    </>
  );
}

/** What limits the shuttle's speed, as text; an unknown reason is shown as it is. */
function speedLimitText(vehicle: VehicleScene): string {
  const t = texts.value;
  const reason = vehicle.driving?.limited_by ?? "";
  if (reason === "") return t.none;
  if (reason.startsWith(SECTION)) return `${t.section_ahead} (${reason.slice(SECTION.length)})`;
  return t.limits[reason] ?? reason;
}
