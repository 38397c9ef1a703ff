import { signal } from "@preact/signals";
import { answerOf, api } from "../shared/api/client";
import { Fetched } from "./fetched";

export const withClosed = signal(false);
export const openRidesOnly = signal(true);

const OPEN_STATES = ["requested", "assigned", "boarding", "aboard"] as const;

export const incidents = new Fetched(() =>
  answerOf(
    api.GET("/api/v1/incidents", { params: { query: { closed: withClosed.peek(), limit: 200 } } }),
  ),
);

export const rides = new Fetched(() =>
  answerOf(
    api.GET("/api/v1/rides", {
      params: { query: { state: openRidesOnly.peek() ? [...OPEN_STATES] : null, limit: 200 } },
    }),
  ),
);

export const runs = new Fetched(() =>
  answerOf(api.GET("/api/v1/runs", { params: { query: { limit: 200 } } })),
);

export const tokens = new Fetched(() => answerOf(api.GET("/api/v1/developer-tokens")));
