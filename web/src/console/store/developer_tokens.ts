import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const developerTokens = new Resource(() => resultOf(api.GET("/api/v1/developer-tokens")));
