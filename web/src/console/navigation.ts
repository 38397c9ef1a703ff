import { signal } from "@preact/signals";
import type { Address, Page } from "./address";
import { addressFrom, fragmentOf } from "./address";

export const address = signal<Address>(addressFrom(location.hash));

window.addEventListener("hashchange", () => {
  address.value = addressFrom(location.hash);
});

export function goTo(page: Page, ...ids: string[]): void {
  location.hash = fragmentOf(page, ...ids);
}
