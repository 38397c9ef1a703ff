import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const mapVersions = new Resource(() => resultOf(api.GET("/api/v1/maps")));
export const localizationMaps = new Resource(() => resultOf(api.GET("/api/v1/localization-maps")));
export const mapDrafts = new Resource(() => resultOf(api.GET("/api/v1/maps/drafts")));
