import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const recordings = new Resource(() =>
  resultOf(api.GET("/api/v1/recordings", { params: { query: { limit: 100 } } })),
);
