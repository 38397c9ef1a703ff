import { signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

/** Which rides are listed; "" for any. day: YYYY-MM-DD of the campus, by the time of the request. */
export interface RideSearch {
  readonly open_only: boolean;
  readonly code: string;
  readonly stop_id: string;
  readonly vehicle_id: string;
  readonly day: string;
}

export const EVERY_OPEN_RIDE: RideSearch = {
  open_only: true,
  code: "",
  stop_id: "",
  vehicle_id: "",
  day: "",
};

export const rideSearch = signal<RideSearch>(EVERY_OPEN_RIDE);
/** Begin and end of the searched day; set together with it, since both depend on the campus's timezone. */
export const searchedDay = signal<{ readonly since: string; readonly before: string } | null>(null);

const OPEN_STATES = ["requested", "assigned", "boarding", "aboard"] as const;

export const rides = new Resource(() => {
  const { open_only, code, stop_id, vehicle_id } = rideSearch.peek();
  const day = searchedDay.peek();
  return resultOf(
    api.GET("/api/v1/rides", {
      params: {
        query: {
          state: open_only ? [...OPEN_STATES] : null,
          limit: 200,
          ...(code === "" ? {} : { code }),
          ...(stop_id === "" ? {} : { stop_id }),
          ...(vehicle_id === "" ? {} : { vehicle_id }),
          ...(day ?? {}),
        },
      },
    }),
  );
});
