import { signal } from "@preact/signals";

/** The page's monotonic clock, updated once a second; texts such as "12 s ago" read it to stay current. */
export const monotonic_ms = signal(performance.now());

window.setInterval(() => {
  monotonic_ms.value = performance.now();
}, 1000);
