import type { Condition, Urgency } from "../../shared/scene/condition";
import { conditionOf, urgencyOf } from "../../shared/scene/condition";
import type { VehicleScene } from "../../shared/scene/scene";

/** What the list shows: all shuttles, those that need an operator, or those of one kind of state. */
export type FleetFilter = "all" | Urgency | "out_of_service";

export const FLEET_FILTERS: readonly FleetFilter[] = [
  "all",
  "danger",
  "warning",
  "good",
  "calm",
  "out_of_service",
];

const DIGITS = /\d+/g;
const keys = new Map<string, string>();

/** A text whose order is the natural one of names: 2 before 10. */
function orderKey(name: string): string {
  let key = keys.get(name);
  if (key === undefined) {
    key = name.toLocaleLowerCase().replace(DIGITS, (digits) => digits.padStart(12, "0"));
    keys.set(name, key);
  }
  return key;
}

export function inNaturalOrder(vehicles: readonly VehicleScene[]): readonly VehicleScene[] {
  return [...vehicles].sort((a, b) => {
    const [left, right] = [orderKey(a.facts.name), orderKey(b.facts.name)];
    if (left !== right) return left < right ? -1 : 1;
    return a.vehicle_id < b.vehicle_id ? -1 : 1;
  });
}

export function passesFilter(vehicle: VehicleScene, filter: FleetFilter): boolean {
  if (filter === "all") return true;
  if (filter === "out_of_service") return !vehicle.facts.in_service;
  return urgencyOf(conditionOf(vehicle)) === filter;
}

/** Every word of the query is in the shuttle's name, id, condition or next stop. */
export function matchesQuery(
  vehicle: VehicleScene,
  query: string,
  conditionName: (condition: Condition) => string,
  stopName: (stop_id: string) => string,
): boolean {
  const words = query.toLocaleLowerCase().split(/\s+/).filter(Boolean);
  if (words.length === 0) return true;
  const { facts, task } = vehicle;
  const next = task.next_stop === "" ? "" : stopName(task.next_stop);
  const text =
    `${facts.name} ${vehicle.vehicle_id} ${conditionName(conditionOf(vehicle))} ${next}`.toLocaleLowerCase();
  return words.every((word) => text.includes(word));
}
