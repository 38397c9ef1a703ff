import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { answerOf, api } from "../../shared/api/client";
import { second } from "../../shared/live/clock";
import type { VehicleScene } from "../../shared/scene/scene";
import { BackIcon } from "../../shared/ui/icons";
import { ProblemNote } from "../../shared/ui/notes";
import { goTo } from "../navigation";
import { Fetched } from "../store/fetched";
import { clock } from "../texts/clocks";
import { stopTitle } from "../texts/stop_title";
import { words } from "../texts/words";
import { ConditionChip } from "./condition_chip";
import type { VehicleFactsProps } from "./driving_facts";
import { WatchedAreas, limitOf } from "./driving_facts";
import { ShiftForm } from "./shift_form";
import { Signboard } from "./signboard";
import { VehicleCommands } from "./vehicle_commands";

/** Everything that is known of one shuttle from a scene; live and replayed alike. */
export function VehicleFacts({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const say = words.value;
  const heard_s = Math.max(0, Math.round((now_ms - vehicle.heard_ms) / 1000));
  const aboard = vehicle.aboard.map(
    (ride_id) => scene.rides.find((ride) => ride.ride_id === ride_id)?.ride_code ?? ride_id,
  );
  const next = vehicle.next_stop === "" ? say.to_rest : stopTitle(vehicle.next_stop);
  const facts: readonly (readonly [string, string])[] = [
    [say.speed, say.kmh((vehicle.speed_mps * 3.6).toFixed(1))],
    [say.mode, say.modes[vehicle.mode] ?? vehicle.mode],
    [say.battery, `${(vehicle.battery_ratio * 100).toFixed(0)} %`],
    [say.heard, vehicle.heard_ms === 0 ? say.never : say.ago(heard_s)],
    [say.doors, vehicle.doors_open ? say.doors_open : say.doors_closed],
    [say.next_stop, next],
    [say.aboard, [say.seats_taken(vehicle.people_aboard, vehicle.seats), ...aboard].join(" · ")],
    [
      say.obstacle,
      vehicle.obstacle_m === null ? say.none : say.metres(vehicle.obstacle_m.toFixed(1)),
    ],
    [say.limited_by, limitOf(vehicle)],
    [say.waits_for, vehicle.waiting_for || say.none],
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
          <dt>{say.order}</dt>
          <dd>{vehicle.order_id || say.none}</dd>
        </div>
      </dl>
      <WatchedAreas vehicle={vehicle} scene={scene} now_ms={now_ms} />
      {vehicle.faults.length > 0 && (
        <div class="note danger">
          <div>
            <strong>{say.faults}</strong>
            <p>{vehicle.faults.join(", ")}</p>
          </div>
        </div>
      )}
    </>
  );
}

/** A shuttle as the operator has it in hand: facts, commands and the plan ahead. */
export function VehiclePanel({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const say = words.value;
  return (
    <section class="block vehicle" aria-label={vehicle.name}>
      <header class="block-head">
        <button type="button" class="button quiet small" onClick={() => goTo("live")}>
          <BackIcon />
          {say.all_vehicles}
        </button>
      </header>
      <div class="row-head">
        <h2>{vehicle.name}</h2>
        <ConditionChip vehicle={vehicle} />
        {!vehicle.in_service && <span class="chip warning">{say.out_of_service}</span>}
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
  const say = words.value;
  const visits = detail.value.value?.visits.filter((visit) => visit.state !== "done") ?? [];
  if (detail.problem.value !== null) return <ProblemNote problem={detail.problem.value} />;
  return (
    <div>
      <h3>{say.visits}</h3>
      {detail.value.value?.hold_ends != null && (
        <p class="hint">{say.held_until(clock(detail.value.value.hold_ends))}</p>
      )}
      {detail.value.value?.charged_at != null && (
        <p class="hint">{say.charged_at(clock(detail.value.value.charged_at))}</p>
      )}
      {detail.value.value?.order_waits === true && <p class="hint">{say.order_waits}</p>}
      {visits.length === 0 && <p class="hint">{say.no_visits}</p>}
      <ol class="visits">
        {visits.map((visit) => (
          <li key={visit.visit_id}>
            <span>
              {visit.stop_id === "" ? say.visit_kinds[visit.kind] : stopTitle(visit.stop_id)}
              <small>
                {[say.visit_states[visit.state], say.rest_reasons[visit.why]]
                  .filter((text) => text)
                  .join(" · ")}
              </small>
            </span>
            <span class="people">
              {visit.board.length > 0 && say.boards(visit.board.length)}{" "}
              {visit.alight.length > 0 && say.alights(visit.alight.length)}
            </span>
            <time>{visit.eta === null ? "" : clock(visit.eta)}</time>
          </li>
        ))}
      </ol>
    </div>
  );
}
