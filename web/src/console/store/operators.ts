import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const operators = new Resource(() => resultOf(api.GET("/api/v1/operators")));
