import { expect, test } from "vitest";
import { assetsIn, routeOf, ticketOf } from "./routes";

const token = "t".repeat(32);

test.each([
  ["GET", "/", "shell"],
  ["GET", "/assets/main-abc.js", "asset"],
  ["GET", "/api/v1/stops", "data"],
  ["GET", "/api/v1/timetable", "data"],
  ["GET", `/api/v1/rides/${token}`, "ticket"],
  ["POST", `/api/v1/rides/${token}/cancel`, "ticket_change"],
  ["POST", "/api/v1/rides", "network"],
  ["GET", "/api/v1/rides/lookup", "network"],
  ["GET", "/api/v1/session", "network"],
  ["GET", "/console", "network"],
])("%s %s is %s", (method, path, route) => {
  expect(routeOf(method, path)).toBe(route);
});

test("a change of a ride concerns its ticket", () => {
  expect(ticketOf(`/api/v1/rides/${token}/cancel`)).toBe(`/api/v1/rides/${token}`);
});

test("the scripts of a page, and those that a script loads later, are found", () => {
  expect(assetsIn('<script src="/assets/a-1.js"></script><link href="/assets/b-2.css">')).toEqual([
    "/assets/a-1.js",
    "/assets/b-2.css",
  ]);
  expect(assetsIn('import("./map-3.js"),["assets/map-4.css"]')).toEqual([
    "/assets/map-3.js",
    "/assets/map-4.css",
  ]);
});
