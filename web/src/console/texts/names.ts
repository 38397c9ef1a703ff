import { campus } from "../../shared/campus/campus";
import { language } from "../../shared/texts/language";
import { roadName } from "../closures/roads";
import { link } from "../session";
import { stopName } from "./stop_names";
import { texts } from "./texts";

/** The shuttle's name; its id where the fleet has no such shuttle any more. */
export function vehicleName(vehicle_id: string): string {
  const vehicles = link.value?.scene.value?.vehicles ?? [];
  return vehicles.find((each) => each.vehicle_id === vehicle_id)?.facts.name || vehicle_id;
}

/** The code of a ride under way; "" for others, whose id says nothing to people. */
export function rideCode(ride_id: string): string {
  const rides = link.value?.scene.value?.rides ?? [];
  return rides.find((ride) => ride.ride_id === ride_id)?.ride_code ?? "";
}

/** The name of the road that a lane or one of its sections belongs to. */
export function roadNameById(id: string): string {
  const geometry = campus.value?.geometry;
  const lane_id = id.replace(/\/\d+$/, "");
  const lane = geometry?.lanes.find((each) => each.lane_id === lane_id);
  if (geometry === undefined || lane === undefined) return id;
  return roadName(lane, geometry.stops, language.value, texts.value.road_near);
}

/** "Crossing near Main Library" */
export function areaName(area_id: string): string {
  const t = texts.value;
  const geometry = campus.value?.geometry;
  const corner = geometry?.areas.get(area_id)?.[0];
  if (geometry === undefined || corner === undefined) return area_id;
  const away_m = (stop: { x_m: number; y_m: number }) =>
    Math.hypot(stop.x_m - corner[0], stop.y_m - corner[1]);
  const nearest = [...geometry.stops].sort((a, b) => away_m(a) - away_m(b))[0];
  const kind = area_id.startsWith("crossing") ? t.area_kinds.crossing : t.area_kinds.intersection;
  return nearest === undefined ? kind : t.area_near(kind, stopName(nearest.stop_id));
}

const TOKEN = /[\p{L}\p{N}_@/>-]+(?:[.:][\p{L}\p{N}_@/>-]+)*/gu;

/** A text of the server or a shuttle, with names in place of the ids and codes in it. */
export function withNames(text: string): string {
  return text.replace(TOKEN, nameOf).replace(/ {2,}/g, " ").trim();
}

function nameOf(token: string): string {
  const t = texts.value;
  if (token in t.fault_codes) return t.fault_codes[token as keyof typeof t.fault_codes];
  if (token in t.hold_reasons) return t.hold_reasons[token as keyof typeof t.hold_reasons];
  if (token.includes("_") && token in t.states) return t.states[token as keyof typeof t.states];
  if (/^ride-[\da-z]/.test(token)) return rideCode(token);
  const [vehicle, stop] = [vehicleName(token), stopName(token)];
  if (vehicle !== token) return vehicle;
  return stop !== token ? stop : roadNameById(token);
}
