import { signal } from "@preact/signals";

/** What the ride's view puts before the page's title: "3–6 min", "Here"; "" for nothing. */
export const title_prefix = signal("");
