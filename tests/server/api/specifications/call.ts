// A client of openapi-fetch with the types that openapi-typescript makes: lists stops, books a ride with a
// developer token, and reads the ride.
import createClient from "openapi-fetch";
import type { paths } from "./schema.js";

const [server, token] = process.argv.slice(2);
const client = createClient<paths>({
  baseUrl: server ?? "",
  headers: { Authorization: `Bearer ${token}` },
});
const { data: stops } = await client.GET("/api/v1/stops");
const [first, second] = stops ?? [];
if (first === undefined || second === undefined) throw new Error("the map has no stops");
const { data: ticket, error } = await client.POST("/api/v1/rides", {
  body: { from_stop: first.stop_id, to_stop: second.stop_id, party: 1, wheelchairs: 0, may_walk: false },
});
if (ticket === undefined) throw new Error(error.detail);
const { data: ride } = await client.GET("/api/v1/rides/id/{ride_id}", {
  params: { path: { ride_id: ticket.ride_id } },
});
console.log(JSON.stringify({ ride_id: ride?.ride_id, source: ride?.source, state: ride?.state }));
