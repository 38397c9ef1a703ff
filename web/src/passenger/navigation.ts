import { signal } from "@preact/signals";
import type { Address } from "./address";
import { addressFrom, fragmentOf } from "./address";

export const address = signal<Address>(addressFrom(location.hash));

window.addEventListener("hashchange", () => {
  address.value = addressFrom(location.hash);
});

export function goTo(next: Address): void {
  location.hash = fragmentOf(next);
}
