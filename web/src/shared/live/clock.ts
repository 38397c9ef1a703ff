import { signal } from "@preact/signals";

/** Ticks once a second, for words like "12 s ago"; read it where such words are shown. */
export const second = signal(performance.now());

window.setInterval(() => {
  second.value = performance.now();
}, 1000);
