import { idempotencyKey } from "../../shared/api/idempotency_key";
import { batch, computed, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import { fromLocalInput } from "../../shared/texts/times";
import type { LastTrip } from "./last_trips";

export type RideEnd = "pickup" | "destination";

/** The booking form as the passenger has filled it in so far. */
export const pickup = signal("");
export const destination = signal("");
export const party = signal(1);
export const wheelchairs = signal(0);
/** The passenger also accepts other stops within walking distance. */
export const mayWalk = signal(false);
/** Earliest pickup in the campus's local time, as the input holds it; "" means now. */
export const earliest = signal("");
/** The end of the ride that the next tap on a stop sets. */
export const nextEnd = computed<RideEnd>(() => (pickup.value === "" ? "pickup" : "destination"));
export const canBook = computed(() => pickup.value !== "" && destination.value !== "");

export function chooseStop(end: RideEnd, stop_id: string): void {
  batch(() => {
    const [own, other] = end === "pickup" ? [pickup, destination] : [destination, pickup];
    if (other.value === stop_id) other.value = "";
    own.value = stop_id;
  });
}

/** Sets an end of the ride; a tap on a stop that is already an end clears it. */
export function tapStop(stop_id: string): void {
  if (pickup.value === stop_id) pickup.value = "";
  else if (destination.value === stop_id) destination.value = "";
  else chooseStop(nextEnd.value, stop_id);
}

export function swapEnds(): void {
  batch(() => {
    [pickup.value, destination.value] = [destination.value, pickup.value];
  });
}

export function setParty(people: number): void {
  batch(() => {
    party.value = people;
    wheelchairs.value = Math.min(wheelchairs.value, people);
  });
}

/** The trip that the form holds, without its time. */
export function currentTrip(): LastTrip {
  return {
    from: pickup.value,
    to: destination.value,
    party: party.value,
    wheelchairs: wheelchairs.value,
  };
}

/** An earlier trip, for now. */
export function fillTrip(trip: LastTrip): void {
  batch(() => {
    pickup.value = trip.from;
    destination.value = trip.to;
    party.value = trip.party;
    wheelchairs.value = trip.wheelchairs;
    earliest.value = "";
    mayWalk.value = false;
  });
}

export function clearEnds(): void {
  batch(() => {
    pickup.value = "";
    destination.value = "";
    earliest.value = "";
  });
}

let attempt: { readonly request: string; readonly key: string } | null = null;

/**
 * Books the ride. If a response was lost and the same request is sent again, it carries the same key, so that
 * the server books only one ride.
 */
export async function bookRide(timezone: string): Promise<Result<Schemas["RideTicket"]>> {
  const time = earliest.value === "" ? null : fromLocalInput(earliest.value, timezone);
  const body = {
    from_stop: pickup.value,
    to_stop: destination.value,
    party: party.value,
    wheelchairs: wheelchairs.value,
    earliest: time?.toISOString() ?? null,
    may_walk: mayWalk.value,
  };
  const request = JSON.stringify(body);
  if (attempt?.request !== request) attempt = { request, key: idempotencyKey() };
  const result = await resultOf(
    api.POST("/api/v1/rides", {
      body,
      params: { header: { "idempotency-key": attempt.key } },
    }),
  );
  if (result.ok) attempt = null;
  return result;
}
