import { signal } from "@preact/signals";

const query = matchMedia("(prefers-reduced-motion: reduce)");

/** Whether the user asked the browser for less motion. */
export const prefersReducedMotion = signal(query.matches);

query.addEventListener("change", () => {
  prefersReducedMotion.value = query.matches;
});
