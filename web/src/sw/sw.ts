/// <reference lib="webworker" />
import { noticeFrom, openTicket } from "./notices";
import { assetsIn, routeOf, ticketOf } from "./routes";

declare const self: ServiceWorkerGlobalScope;

/**
 * The passenger page without a connection: the page itself, the stops, the timetable and the last ticket. What
 * comes from here carries when it was stored, and the page says so. Nothing else is kept, and nothing of the
 * console.
 */
const SHELL = "campusloop-shell-1";
const DATA = "campusloop-data-1";
const TICKET = "campusloop-ticket-1";
const STORED_AT = "Campusloop-Stored-At";
/** A connection that takes longer to bring the page counts as none. */
const SHELL_WITHIN_MS = 4_000;

self.addEventListener("install", (event) => {
  event.waitUntil(fetch("/", { cache: "no-cache" }).then(storeShell));
  void self.skipWaiting();
});

self.addEventListener("activate", (event) => {
  event.waitUntil(dropOtherCaches().then(() => self.clients.claim()));
});

self.addEventListener("fetch", (event) => {
  const { request } = event;
  const { origin, pathname } = new URL(request.url);
  if (origin !== self.location.origin) return;
  switch (routeOf(request.method, pathname)) {
    case "shell":
      event.respondWith(shell(event));
      break;
    case "asset":
      event.respondWith(asset(request));
      break;
    case "data":
      event.respondWith(newest(event, DATA));
      break;
    case "ticket":
      event.respondWith(newest(event, TICKET));
      break;
    case "ticket_change":
      event.respondWith(changed(event, ticketOf(pathname)));
      break;
    case "network":
      break;
  }
});

self.addEventListener("push", (event) => {
  const notice = noticeFrom(event.data?.text());
  if (notice === null) return;
  const { title, body, tag, language, address } = notice;
  const shown = { body, tag, lang: language, icon: "/icon.svg", data: address, renotify: true };
  event.waitUntil(self.registration.showNotification(title, shown));
});

self.addEventListener("notificationclick", (event) => {
  event.notification.close();
  event.waitUntil(openTicket(self.clients, String(event.notification.data)));
});

async function shell(event: FetchEvent): Promise<Response> {
  const kept = await (await caches.open(SHELL)).match("/");
  try {
    const signal = kept === undefined ? null : AbortSignal.timeout(SHELL_WITHIN_MS);
    const page = await fetch("/", { cache: "no-cache", signal });
    if (page.ok) event.waitUntil(storeShell(page.clone()));
    return page;
  } catch (failure) {
    if (kept !== undefined) return kept;
    throw failure;
  }
}

/** Names of assets change with their content, so that a kept one is never old. */
async function asset(request: Request): Promise<Response> {
  return (await (await caches.open(SHELL)).match(request)) ?? fetch(request);
}

/** From the server where it answers; otherwise the last answer, with the time when it was stored. */
async function newest(event: FetchEvent, name: string): Promise<Response> {
  const cache = await caches.open(name);
  const key = new URL(event.request.url).pathname;
  try {
    const answer = await fetch(event.request);
    if (answer.ok) event.waitUntil(store(cache, key, answer.clone(), name === TICKET));
    else if (answer.status === 404) event.waitUntil(cache.delete(key));
    return answer;
  } catch (failure) {
    const kept = await cache.match(key);
    if (kept !== undefined) return kept;
    throw failure;
  }
}

/** A ticket that was changed is fetched again: the kept one would show the ride as it was. */
async function changed(event: FetchEvent, ticket: string): Promise<Response> {
  const answer = await fetch(event.request);
  if (answer.ok)
    event.waitUntil(
      caches.open(TICKET).then(async (cache) => {
        const ride = await fetch(ticket);
        if (ride.ok) await store(cache, ticket, ride, true);
      }),
    );
  return answer;
}

/** alone: only this one is kept. Who finds the phone reads no other rides. */
async function store(cache: Cache, key: string, answer: Response, alone: boolean): Promise<void> {
  const headers = new Headers(answer.headers);
  headers.set(STORED_AT, new Date().toISOString());
  headers.delete("Content-Encoding");
  const body = await answer.blob();
  if (alone) for (const other of await cache.keys()) await cache.delete(other);
  await cache.put(key, new Response(body, { headers }));
}

/** Keeps the page with all of its scripts and styles, and forgets those of the page before. */
async function storeShell(page: Response): Promise<void> {
  if (!page.ok) return;
  const cache = await caches.open(SHELL);
  const text = await page.clone().text();
  const kept = await cache.match("/");
  if (kept !== undefined && (await kept.text()) === text) return;
  const wanted = new Set(["/icon.svg", ...assetsIn(text)]);
  for (const path of wanted) {
    if (!(await cache.match(path))) await cache.add(path);
    // A set grows while it is walked: what a script loads later is found as well.
    if (path.endsWith(".js"))
      for (const further of assetsIn(await (await cache.match(path))!.text())) wanted.add(further);
  }
  await cache.put("/", page);
  for (const request of await cache.keys()) {
    const path = new URL(request.url).pathname;
    if (path !== "/" && !wanted.has(path)) await cache.delete(request);
  }
}

async function dropOtherCaches(): Promise<void> {
  const own = new Set([SHELL, DATA, TICKET]);
  for (const name of await caches.keys()) if (!own.has(name)) await caches.delete(name);
}
