import { signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const includeClosed = signal(false);

export const incidents = new Resource(() =>
  resultOf(
    api.GET("/api/v1/incidents", {
      params: { query: { closed: includeClosed.peek(), limit: 200 } },
    }),
  ),
);
