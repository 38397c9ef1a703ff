/** What the service worker does with a request; "network" leaves it alone. */
export type Route = "shell" | "asset" | "data" | "ticket" | "ticket_change" | "network";

/** What a passenger may need without a connection. */
const DATA = /^\/api\/v1\/(campus|campus\/map|stops|timetable)$/;
const TICKET = /^\/api\/v1\/rides\/[A-Za-z0-9_-]{16,128}$/;
const TICKET_CHANGE =
  /^(\/api\/v1\/rides\/[A-Za-z0-9_-]{16,128})\/(cancel|destination|board|alight)$/;

/** The console is not the worker's: operators must never see a stored page. */
export function routeOf(method: string, path: string): Route {
  if (method === "POST" && TICKET_CHANGE.test(path)) return "ticket_change";
  if (method !== "GET") return "network";
  if (path === "/") return "shell";
  if (path.startsWith("/assets/") || path === "/icon.svg") return "asset";
  if (DATA.test(path)) return "data";
  return TICKET.test(path) ? "ticket" : "network";
}

/** The path of the ticket that such a change concerns. */
export function ticketOf(path: string): string {
  return TICKET_CHANGE.exec(path)?.[1] ?? path;
}

/** The scripts and styles that a page or a script names, as paths. */
export function assetsIn(text: string): readonly string[] {
  const named = text.matchAll(/["'`(](?:\.\/|\/?assets\/)([\w.-]+\.(?:js|css))["'`)]/g);
  return [...new Set([...named].map((match) => `/assets/${match[1]}`))];
}
