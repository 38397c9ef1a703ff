import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const service = new Resource(() => resultOf(api.GET("/api/v1/service")));

export const timetable = new Resource(() => resultOf(api.GET("/api/v1/timetable")));

/** Loads the calendars and today's timetable again: a change of a calendar changes both. */
export async function refreshService(): Promise<void> {
  await Promise.all([service.refresh(), timetable.refresh()]);
}
