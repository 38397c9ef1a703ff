import { signal } from "@preact/signals";

/** Changes once a second; texts such as "12 s ago" read it to stay current. */
export const second = signal(performance.now());

window.setInterval(() => {
  second.value = performance.now();
}, 1000);
