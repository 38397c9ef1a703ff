import type { Schemas } from "../../shared/api/client";
import type { Scene } from "../../shared/scene/scene";
import { stopTitle } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { shiftMinutes } from "./delay";

type RideEffect = Schemas["RideEffectView"];
type DepartureEffect = Schemas["DepartureEffectView"];

interface EffectsListProps {
  readonly effects: Schemas["EffectsView"];
  readonly scene: Scene;
}

/** Whom an intervention concerns: who comes instead, how much later, and who is left with nobody. */
export function EffectsList({ effects, scene }: EffectsListProps) {
  const t = texts.value;
  const name = (vehicle_id: string | null) =>
    scene.vehicles.find((vehicle) => vehicle.vehicle_id === vehicle_id)?.name ?? vehicle_id ?? "";
  if (effects.rides.length === 0 && effects.departures.length === 0)
    return <p class="hint">{t.concerns_nobody}</p>;
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
            {rideEffectTexts(effect, name).map((text) => (
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
            <small>{t.departure}</small>
          </span>
          <span class={effect.vehicle_after === null ? "chip danger" : "chip"}>
            {departureEffectText(effect, name)}
          </span>
        </li>
      ))}
    </ul>
  );
}

const isBad = (effect: RideEffect) =>
  effect.breaks || effect.waits || effect.vehicle_after === null;

function rideEffectTexts(
  effect: RideEffect,
  name: (vehicle_id: string | null) => string,
): string[] {
  const t = texts.value;
  if (effect.vehicle_after === null) return [t.left_with_nobody];
  const told: string[] = [];
  if (effect.vehicle_after !== effect.vehicle_before)
    told.push(t.goes_with(name(effect.vehicle_after)));
  if (effect.waits) told.push(t.waits_until_resumed);
  if (effect.pickup_later_s !== null)
    told.push(t.pickup_shift(shiftMinutes(effect.pickup_later_s)));
  if (effect.arrival_later_s !== null)
    told.push(t.arrival_shift(shiftMinutes(effect.arrival_later_s)));
  if (effect.breaks) told.push(t.promise_breaks);
  return told;
}

function departureEffectText(
  effect: DepartureEffect,
  name: (vehicle_id: string | null) => string,
): string {
  const t = texts.value;
  if (effect.vehicle_after === null) return t.left_with_nobody;
  if (effect.waits) return t.waits_until_resumed;
  if (effect.vehicle_after !== effect.vehicle_before)
    return t.goes_with(name(effect.vehicle_after));
  return t.late(Math.max(1, shiftMinutes(effect.late_after_s)));
}
