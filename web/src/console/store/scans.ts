import { api, resultOf } from "../../shared/api/client";
import { Resource } from "./resource";

export const scanRequests = new Resource(() => resultOf(api.GET("/api/v1/scan-requests")));
export const mapProposals = new Resource(() => resultOf(api.GET("/api/v1/map-proposals")));
