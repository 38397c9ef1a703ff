import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const announcements = new Resource(() =>
  resultOf(api.GET("/api/v1/announcements", { params: { query: { limit: 50 } } })),
);
