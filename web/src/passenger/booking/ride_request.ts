import { batch, computed, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Answer } from "../../shared/api/problem";
import { fromLocalInput } from "../../shared/texts/times";

export type End = "pickup" | "destination";

/** What the passenger has filled in so far. */
export const pickup = signal("");
export const destination = signal("");
export const party = signal(1);
export const wheelchairs = signal(0);
/** Other stops within walking distance will do. */
export const mayWalk = signal(false);
/** Campus local time as the input holds it; "" means now. */
export const earliest = signal("");
/** Which end the next tap on the map or the list chooses. */
export const choosing = computed<End>(() => (pickup.value === "" ? "pickup" : "destination"));
export const canBook = computed(() => pickup.value !== "" && destination.value !== "");

export function chooseStop(end: End, stop_id: string): void {
  batch(() => {
    const [mine, other] = end === "pickup" ? [pickup, destination] : [destination, pickup];
    if (other.value === stop_id) other.value = "";
    mine.value = stop_id;
  });
}

/** A tap on a chosen stop takes it back. */
export function tapStop(stop_id: string): void {
  if (pickup.value === stop_id) pickup.value = "";
  else if (destination.value === stop_id) destination.value = "";
  else chooseStop(choosing.value, stop_id);
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

export function clearEnds(): void {
  batch(() => {
    pickup.value = "";
    destination.value = "";
    earliest.value = "";
  });
}

let attempt: { readonly wish: string; readonly key: string } | null = null;

/**
 * Books what is filled in. A repeat of the same wish after a lost answer carries the same key, so that it can
 * never end in two rides.
 */
export async function book(timezone: string): Promise<Answer<Schemas["RideTicket"]>> {
  const time = earliest.value === "" ? null : fromLocalInput(earliest.value, timezone);
  const body = {
    from_stop: pickup.value,
    to_stop: destination.value,
    party: party.value,
    wheelchairs: wheelchairs.value,
    earliest: time?.toISOString() ?? null,
    may_walk: mayWalk.value,
  };
  const wish = JSON.stringify(body);
  if (attempt?.wish !== wish) attempt = { wish, key: randomKey() };
  const answer = await answerOf(
    api.POST("/api/v1/rides", {
      body,
      params: { header: { "idempotency-key": attempt.key } },
    }),
  );
  if (answer.ok) attempt = null;
  return answer;
}

/** crypto.randomUUID exists on secure origins only; a LAN address without TLS is none. */
export function randomKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
}
