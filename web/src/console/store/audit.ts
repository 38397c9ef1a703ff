import { signal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const auditBy = signal("");

export const auditEntries = new Resource(() => {
  const by = auditBy.peek().trim();
  return resultOf(api.GET("/api/v1/audit", { params: { query: by === "" ? {} : { by } } }));
});
