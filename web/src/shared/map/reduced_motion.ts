import { signal } from "@preact/signals";

const query = matchMedia("(prefers-reduced-motion: reduce)");

/** The reader prefers things that do not move by themselves. */
export const prefersStill = signal(query.matches);

query.addEventListener("change", () => {
  prefersStill.value = query.matches;
});
