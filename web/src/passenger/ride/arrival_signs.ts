import { effect, signal } from "@preact/signals";
import type { RideState } from "../../shared/state/ride_state";
import { title_prefix } from "../page_title";
import { nowOf, shortText } from "./ride_texts";
import type { RideTracker } from "./ride_tracker";

const STORED_AS = "campusloop.vibration";
/** Two pulses: felt in a pocket, and unlike a message's one. */
const PULSES_MS = [300, 150, 300];

/** Whether this phone can vibrate at all. */
export const canVibrate = "vibrate" in navigator;

/** The passenger wants it; it is on until it is switched off. */
export const vibrates = signal(localStorage.getItem(STORED_AS) !== "off");

export function setVibration(on: boolean): void {
  vibrates.value = on;
  localStorage.setItem(STORED_AS, on ? "on" : "off");
}

/** Shows the ride in the page's title, and lets the phone vibrate when its shuttle has come. Returns the end. */
export function showArrival(ride: RideTracker): () => void {
  let last: RideState["kind"] | null = null;
  const stop = effect(() => {
    const state = ride.progress.value?.state ?? null;
    if (state === null) return;
    // Once at its end: what follows may have a title of its own.
    if (state.kind !== "ended") title_prefix.value = shortText(state, nowOf(ride));
    else if (last !== "ended") title_prefix.value = "";
    if (hasCome(last, state.kind)) pulse();
    last = state.kind;
  });
  return () => {
    stop();
    title_prefix.value = "";
  };
}

/** Where the phone can, and its owner wants it. */
export function pulse(): void {
  if (canVibrate && vibrates.peek()) navigator.vibrate(PULSES_MS);
}

/** Only a change counts: a page that is opened while the shuttle stands there says it by itself. */
export function hasCome(before: RideState["kind"] | null, now: RideState["kind"]): boolean {
  return now === "at_stop" && before !== null && before !== "at_stop";
}
