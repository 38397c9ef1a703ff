import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const activeSeries = new Resource(() =>
  resultOf(api.GET("/api/v1/series", { params: { query: { state: ["active"], limit: 200 } } })),
);
