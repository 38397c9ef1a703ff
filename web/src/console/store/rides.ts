import { signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const openRidesOnly = signal(true);

const OPEN_STATES = ["requested", "assigned", "boarding", "aboard"] as const;

export const rides = new Resource(() =>
  resultOf(
    api.GET("/api/v1/rides", {
      params: { query: { state: openRidesOnly.peek() ? [...OPEN_STATES] : null, limit: 200 } },
    }),
  ),
);
