import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { answerOf, api } from "../../shared/api/client";
import { second } from "../../shared/live/clock";
import type { VehicleScene } from "../../shared/scene/scene";
import { ProblemNote } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { Fetched } from "../store/resource";
import { stopTitle } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { clock } from "../texts/times";
import { ConditionChip } from "./condition_chip";
import { Signboard } from "./hmi_output";
import type { VehicleFactsProps } from "./observation_area_list";
import { WatchedAreas, limitOf } from "./observation_area_list";
import { ShiftForm } from "./shift_form";
import { VehicleCommands } from "./vehicle_commands";

/** Everything that is known of one shuttle from a scene; live and replayed alike. */
export function VehicleFacts({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const t = texts.value;
  const heard_s = Math.max(0, Math.round((now_ms - vehicle.heard_ms) / 1000));
  const aboard = vehicle.aboard.map(
    (ride_id) => scene.rides.find((ride) => ride.ride_id === ride_id)?.ride_code ?? ride_id,
  );
  const next = vehicle.next_stop === "" ? t.to_rest : stopTitle(vehicle.next_stop);
  const facts: readonly (readonly [string, string])[] = [
    [t.speed, t.kmh((vehicle.speed_mps * 3.6).toFixed(1))],
    [t.mode, t.modes[vehicle.mode] ?? vehicle.mode],
    [t.battery, `${(vehicle.battery_ratio * 100).toFixed(0)} %`],
    [t.heard, vehicle.heard_ms === 0 ? t.never : t.ago(heard_s)],
    [t.doors, vehicle.doors_open ? t.doors_open : t.doors_closed],
    [t.next_stop, next],
    [t.aboard, [t.seats_taken(vehicle.people_aboard, vehicle.seats), ...aboard].join(" · ")],
    [t.obstacle, vehicle.obstacle_m === null ? t.none : t.metres(vehicle.obstacle_m.toFixed(1))],
    [t.limited_by, limitOf(vehicle)],
    [t.waits_for, vehicle.waiting_for || t.none],
  ];
  return (
    <>
      <Signboard screen={vehicle.screen} spoken={vehicle.spoken} />
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
      <WatchedAreas vehicle={vehicle} scene={scene} now_ms={now_ms} />
      {vehicle.faults.length > 0 && (
        <div class="note danger">
          <div>
            <strong>{t.faults}</strong>
            <p>{vehicle.faults.join(", ")}</p>
          </div>
        </div>
      )}
    </>
  );
}

/** A shuttle as the operator has it in hand: facts, commands and the plan ahead. */
export function VehiclePanel({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const t = texts.value;
  return (
    <section class="block vehicle" aria-label={vehicle.name}>
      <header class="block-head">
        <button type="button" class="button quiet small" onClick={() => goTo("live")}>
          <BackIcon />
          {t.all_vehicles}
        </button>
      </header>
      <div class="row-head">
        <h2>{vehicle.name}</h2>
        <ConditionChip vehicle={vehicle} />
        {!vehicle.in_service && <span class="chip warning">{t.out_of_service}</span>}
      </div>
      <VehicleCommands vehicle={vehicle} scene={scene} />
      <VehicleFacts vehicle={vehicle} scene={scene} now_ms={now_ms} />
      <VisitsAhead vehicle={vehicle} />
      <ShiftForm vehicle_id={vehicle.vehicle_id} />
    </section>
  );
}

const REFRESH_EVERY_S = 5;

function VisitsAhead({ vehicle }: { readonly vehicle: VehicleScene }) {
  const { vehicle_id } = vehicle;
  const detail = useMemo(
    () =>
      new Fetched(() =>
        answerOf(api.GET("/api/v1/vehicles/{vehicle_id}", { params: { path: { vehicle_id } } })),
      ),
    [vehicle_id],
  );
  const ticks = useSignal(0);
  useSignalEffect(() => {
    if (second.value > 0 && (ticks.value = ticks.peek() + 1) % REFRESH_EVERY_S === 0)
      void detail.refresh();
  });
  useEffect(() => void detail.refresh(), [detail, vehicle.order_id, vehicle.visit_id]);
  const t = texts.value;
  const visits = detail.value.value?.visits.filter((visit) => visit.state !== "done") ?? [];
  if (detail.problem.value !== null) return <ProblemNote problem={detail.problem.value} />;
  return (
    <div>
      <h3>{t.visits}</h3>
      {detail.value.value?.hold_ends != null && (
        <p class="hint">{t.held_until(clock(detail.value.value.hold_ends))}</p>
      )}
      {detail.value.value?.charged_at != null && (
        <p class="hint">{t.charged_at(clock(detail.value.value.charged_at))}</p>
      )}
      {detail.value.value?.order_waits === true && <p class="hint">{t.order_waits}</p>}
      {visits.length === 0 && <p class="hint">{t.no_visits}</p>}
      <ol class="visits">
        {visits.map((visit) => (
          <li key={visit.visit_id}>
            <span>
              {visit.stop_id === "" ? t.visit_kinds[visit.kind] : stopTitle(visit.stop_id)}
              <small>
                {[t.visit_states[visit.state], t.rest_reasons[visit.why]]
                  .filter((text) => text)
                  .join(" · ")}
              </small>
            </span>
            <span class="people">
              {visit.board.length > 0 && t.boards(visit.board.length)}{" "}
              {visit.alight.length > 0 && t.alights(visit.alight.length)}
            </span>
            <time>{visit.eta === null ? "" : clock(visit.eta)}</time>
          </li>
        ))}
      </ol>
    </div>
  );
}
