import type { Schemas } from "../../shared/api/client";
import { modeOf, type Scene, type VehicleScene } from "../../shared/scene/scene";
import type { Knowledge } from "../../shared/state/knowledge";
import type { VehicleState } from "../../shared/state/vehicle_state";
import { vehicleState } from "../../shared/state/vehicle_state";
import { stopName } from "../texts/stop_names";
import { roadNameById, withNames } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTimeWithSeconds } from "../texts/times";
import { HmiOutput } from "./hmi_output";
import { ObservationAreaList } from "./observation_area_list";

interface VehicleStatusProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  /** Of the scene; in a replay its time lies in the past. */
  readonly knowledge: Knowledge;
}

/** What a scene, live or replayed, says of one shuttle. */
export function VehicleStatus({ vehicle, scene, knowledge }: VehicleStatusProps) {
  const t = texts.value;
  const { now_ms } = knowledge;
  const age_s = Math.max(0, Math.round((now_ms - vehicle.heard_ms) / 1000));
  const { facts, task, status } = vehicle;
  const aboard = (status?.aboard ?? []).map(
    (ride_id) => scene.rides.find((ride) => ride.ride_id === ride_id)?.ride_code ?? "",
  );
  const next = task.next_stop === "" ? t.to_resting_place : stopName(task.next_stop);
  const held = holdText(vehicle);
  const stopped = stopText(vehicleState(vehicle, knowledge));
  const obstacle_m = status?.obstacle_m ?? null;
  const rows: readonly (readonly [string, string])[] = [
    [t.speed, status === null ? t.unknown : t.kmh((status.speed_mps * 3.6).toFixed(1))],
    [t.mode, t.modes[modeOf(vehicle)]],
    ...(held === "" ? [] : [[t.held_because, held] as const]),
    ...(stopped === "" ? [] : [[t.stopped, stopped] as const]),
    [t.localization, localizationText(status)],
    [t.battery, batteryText(status)],
    [t.last_heard, vehicle.heard_ms === 0 ? t.never : t.ago(age_s)],
    [t.doors, status === null ? t.unknown : status.doors_open ? t.doors_open : t.doors_closed],
    [t.next_stop, next],
    [
      t.aboard,
      [t.seats_taken(task.people_aboard, facts.seats), ...aboard].filter(Boolean).join(" · "),
    ],
    ...signalRows(vehicle),
    [t.obstacle, obstacle_m === null ? t.none : t.metres(obstacle_m.toFixed(1))],
    [t.limited_by, speedLimitText(vehicle)],
    [t.waits_for_section, status?.waiting_for ? roadNameById(status.waiting_for) : t.none],
  ];
  return (
    <>
      <HmiOutput screen={status?.screen ?? ""} spoken={status?.spoken ?? ""} />
      <dl class="facts">
        {rows.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </div>
        ))}
      </dl>
      <ObservationAreaList vehicle={vehicle} scene={scene} now_ms={now_ms} />
      {status !== null && status.faults.length > 0 && (
        <div class="alert danger">
          <div>
            <strong>{t.faults}</strong>
            <p>{status.faults.map(faultText).join(", ")}</p>
          </div>
        </div>
      )}
    </>
  );
}

/** A fault by its code, and which device it is about if the shuttle says so. */
function faultText({ code, detail }: Schemas["FaultReport"]): string {
  const t = texts.value;
  return detail ? t.fault_of(t.fault_codes[code], detail) : t.fault_codes[code];
}

/** A vehicle that does not measure its battery reports 0. */
export function batteryText(status: VehicleScene["status"]): string {
  if (status === null || status.battery_ratio <= 0) return texts.value.unknown;
  return `${(status.battery_ratio * 100).toFixed(0)} %`;
}

/** How well the shuttle knows where it is; an older agent does not say. */
export function localizationText(status: VehicleScene["status"]): string {
  const t = texts.value;
  const { localization = null } = status ?? {};
  if (localization === null) return t.unknown;
  const phase = t.localization_phases[localization.phase];
  const { position_std_m = null } = localization;
  return position_std_m === null
    ? phase
    : t.position_deviation(phase, t.metres(position_std_m.toFixed(2)));
}

/** What keeps the shuttle from going faster, as text. */
function speedLimitText(vehicle: VehicleScene): string {
  const t = texts.value;
  const reason = vehicle.status?.driving?.limited_by ?? null;
  return reason === null ? t.none : t.limits[reason];
}

/** What its turn signals, headlights and horn do; no row for a shuttle whose by-wire does not say. */
function signalRows(vehicle: VehicleScene): readonly (readonly [string, string])[] {
  const t = texts.value;
  const { turn_signal = null, headlights = null, horn = null } = vehicle.status?.driving ?? {};
  if (turn_signal === null && headlights === null && horn === null) return [];
  const shown = [
    turn_signal === null || turn_signal === "none" ? "" : t.turn_signals[turn_signal],
    headlights === null || headlights === "off" ? "" : t.headlight_beams[headlights],
    horn === true ? t.horn_sounds : "",
  ].filter((text) => text !== "");
  return [[t.lights, shown.length === 0 ? t.none : shown.join(", ")]];
}

/** Since when the shuttle stands or is silent, and what happens next; "" for one that does neither. */
function stopText(state: VehicleState): string {
  const t = texts.value;
  if (state.kind === "unknown") return t.unknown_since(formatTimeWithSeconds(state.since_ms));
  if (state.kind !== "stopped") return "";
  const next =
    state.next === "resumes_at"
      ? t.resumes_at(formatTimeWithSeconds(state.resumes_ms))
      : t.next_steps[state.next];
  if (state.since_ms === null) return next;
  return `${t.stopped_since(formatTimeWithSeconds(state.since_ms))}; ${next}`;
}

/** Why the shuttle does not drive by itself, as text; empty while it does. */
function holdText(vehicle: VehicleScene): string {
  const { hold_reason = null, hold_detail = "" } = vehicle.status ?? {};
  if (hold_reason === null) return "";
  const reason = texts.value.hold_reasons[hold_reason];
  return hold_detail === "" ? reason : `${reason}: ${withNames(hold_detail)}`;
}
