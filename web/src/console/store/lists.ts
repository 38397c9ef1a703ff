import { signal } from "@preact/signals";
import { answerOf, api } from "../../shared/api/client";
import { Fetched } from "./resource";

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

export const service = new Fetched(() => answerOf(api.GET("/api/v1/service")));

export const closures = new Fetched(() => answerOf(api.GET("/api/v1/closures")));

export const timetable = new Fetched(() => answerOf(api.GET("/api/v1/timetable")));

export const seriesList = new Fetched(() =>
  answerOf(api.GET("/api/v1/series", { params: { query: { state: ["active"], limit: 200 } } })),
);

/** What an operator changes in the calendars shows in the day's timetable too. */
export async function serviceChanged(): Promise<void> {
  await Promise.all([service.refresh(), timetable.refresh()]);
}
