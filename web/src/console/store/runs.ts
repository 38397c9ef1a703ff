import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const runs = new Resource(() =>
  resultOf(api.GET("/api/v1/runs", { params: { query: { limit: 200 } } })),
);
