import type { Schemas } from "../../shared/api/client";
import type { VehicleScene } from "../../shared/scene/scene";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTimeOrDateTime } from "../texts/times";
import { delayMinutes } from "./delay";

type RideEffect = Schemas["RideEffectView"];
type DepartureEffect = Schemas["DepartureEffectView"];

interface EffectListProps {
  readonly effects: Schemas["EffectsView"];
  readonly vehicles: readonly VehicleScene[];
}

/** The rides and departures that an intervention or a closure changes, and how. */
export function EffectList({ effects, vehicles }: EffectListProps) {
  const t = texts.value;
  const name = (vehicle_id: string | null) =>
    vehicles.find((vehicle) => vehicle.vehicle_id === vehicle_id)?.facts.name ?? vehicle_id ?? "";
  if (effects.rides.length === 0 && effects.departures.length === 0)
    return <p class="hint">{t.no_effects}</p>;
  return (
    <ul class="visits effects">
      {effects.rides.map((effect) => (
        <li key={effect.ride_id} data-effect={effect.ride_code}>
          <span>
            {effect.ride_code}
            <small>
              {stopName(effect.from_stop)} – {stopName(effect.to_stop)}
            </small>
          </span>
          <span>
            {rideEffectTexts(effect, name).map((text) => (
              <span class={isHarmful(effect) ? "chip danger" : "chip"} key={text}>
                {text}
              </span>
            ))}
          </span>
        </li>
      ))}
      {effects.departures.map((effect) => (
        <li key={effect.departure_id} data-effect={effect.departure_id}>
          <span>
            {effect.departure_id.split("@")[0]}
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

const isHarmful = (effect: RideEffect) =>
  effect.ends || effect.breaks || effect.waits || effect.vehicle_after === null;

function rideEffectTexts(
  effect: RideEffect,
  name: (vehicle_id: string | null) => string,
): string[] {
  const t = texts.value;
  if (effect.ends) return [t.ride_ends];
  if (effect.postponed_to !== null) return [t.put_off(formatTimeOrDateTime(effect.postponed_to))];
  if (effect.vehicle_after === null) return [t.no_vehicle];
  const effect_texts: string[] = [];
  if (effect.vehicle_after !== effect.vehicle_before)
    effect_texts.push(t.moves_to(name(effect.vehicle_after)));
  if (effect.to_stop_after !== effect.to_stop)
    effect_texts.push(t.gets_off_at(stopName(effect.to_stop_after)));
  if (effect.waits) effect_texts.push(t.waits_until_resumed);
  if (effect.pickup_later_s !== null)
    effect_texts.push(t.pickup_shift(delayMinutes(effect.pickup_later_s)));
  if (effect.arrival_later_s !== null)
    effect_texts.push(t.arrival_shift(delayMinutes(effect.arrival_later_s)));
  if (effect.breaks) effect_texts.push(t.promise_breaks);
  return effect_texts;
}

function departureEffectText(
  effect: DepartureEffect,
  name: (vehicle_id: string | null) => string,
): string {
  const t = texts.value;
  if (effect.vehicle_after === null) return t.no_vehicle;
  if (effect.waits) return t.waits_until_resumed;
  if (effect.vehicle_after !== effect.vehicle_before) return t.moves_to(name(effect.vehicle_after));
  return t.late(Math.max(1, delayMinutes(effect.late_after_s)));
}
