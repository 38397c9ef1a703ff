import { signal } from "@preact/signals";
import type { Page, Place } from "./address";
import { fragmentOf, placeFrom } from "./address";

export const place = signal<Place>(placeFrom(location.hash));

window.addEventListener("hashchange", () => {
  place.value = placeFrom(location.hash);
});

export function goTo(page: Page, ...parts: string[]): void {
  location.hash = fragmentOf(page, ...parts);
}
