import type { Schemas } from "../../shared/api/client";
import type { Scene } from "../../shared/scene/scene";
import { stopTitle } from "../texts/stop_title";
import { words } from "../texts/words";
import { shiftMinutes } from "./shift";

type RideEffect = Schemas["RideEffectView"];
type DepartureEffect = Schemas["DepartureEffectView"];

interface EffectsListProps {
  readonly effects: Schemas["EffectsView"];
  readonly scene: Scene;
}

/** Whom an intervention concerns: who comes instead, how much later, and who is left with nobody. */
export function EffectsList({ effects, scene }: EffectsListProps) {
  const say = words.value;
  const name = (vehicle_id: string | null) =>
    scene.vehicles.find((vehicle) => vehicle.vehicle_id === vehicle_id)?.name ?? vehicle_id ?? "";
  if (effects.rides.length === 0 && effects.departures.length === 0)
    return <p class="hint">{say.concerns_nobody}</p>;
  return (
    <ul class="visits effects">
      {effects.rides.map((effect) => (
        <li key={effect.ride_id} data-effect={effect.ride_code}>
          <span>
            {effect.ride_code}
            <small>
              {stopTitle(effect.from_stop)} – {stopTitle(effect.to_stop)}
            </small>
          </span>
          <span>
            {rideWords(effect, name).map((text) => (
              <span class={isBad(effect) ? "chip danger" : "chip"} key={text}>
                {text}
              </span>
            ))}
          </span>
        </li>
      ))}
      {effects.departures.map((effect) => (
        <li key={effect.departure_id} data-effect={effect.departure_id}>
          <span>
            {effect.departure_id}
            <small>{say.departure}</small>
          </span>
          <span class={effect.vehicle_after === null ? "chip danger" : "chip"}>
            {departureWords(effect, name)}
          </span>
        </li>
      ))}
    </ul>
  );
}

const isBad = (effect: RideEffect) =>
  effect.breaks || effect.waits || effect.vehicle_after === null;

function rideWords(effect: RideEffect, name: (vehicle_id: string | null) => string): string[] {
  const say = words.value;
  if (effect.vehicle_after === null) return [say.left_with_nobody];
  const told: string[] = [];
  if (effect.vehicle_after !== effect.vehicle_before)
    told.push(say.goes_with(name(effect.vehicle_after)));
  if (effect.waits) told.push(say.waits_until_resumed);
  if (effect.pickup_later_s !== null)
    told.push(say.pickup_shift(shiftMinutes(effect.pickup_later_s)));
  if (effect.arrival_later_s !== null)
    told.push(say.arrival_shift(shiftMinutes(effect.arrival_later_s)));
  if (effect.breaks) told.push(say.promise_breaks);
  return told;
}

function departureWords(
  effect: DepartureEffect,
  name: (vehicle_id: string | null) => string,
): string {
  const say = words.value;
  if (effect.vehicle_after === null) return say.left_with_nobody;
  if (effect.waits) return say.waits_until_resumed;
  if (effect.vehicle_after !== effect.vehicle_before)
    return say.goes_with(name(effect.vehicle_after));
  return say.late(Math.max(1, shiftMinutes(effect.late_after_s)));
}
