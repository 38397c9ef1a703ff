import { computed, signal } from "@preact/signals";
import type { Schemas } from "../shared/api/client";
import { api, resultOf } from "../shared/api/client";
import type { Problem } from "../shared/api/problem";
import { problemFrom } from "../shared/api/problem";
import { monotonic_ms } from "../shared/live/clock";
import { LiveLink } from "../shared/live/live_link";
import type { Knowledge } from "../shared/state/knowledge";
import { askSecondFactor } from "./account/second_factor_question";

type Session = Schemas["SessionView"];
export type Role = Session["roles"][number];

const SIGNED_IN = "campusloop.signed_in";

/** undefined: not known yet; null: signed out. */
export const session = signal<Session | null | undefined>(undefined);
export const sessionProblem = signal<Problem | null>(null);
export const link = signal<LiveLink | null>(null);

/** The server sends something every 5 s; what is older than this is shown as the past. */
const STALE_S = 7;

/** How old the newest message is, in whole seconds; 0 before the first one. */
export const age_s = computed(() => {
  const last_message_ms = link.value?.last_message_ms.value ?? null;
  if (last_message_ms === null) return 0;
  return Math.max(0, Math.round((monotonic_ms.value - last_message_ms) / 1000));
});

/** Nothing on the page is known to be true any more. */
export const is_stale = computed(
  () => link.value !== null && (link.value.state.value === "lost" || age_s.value > STALE_S),
);

/** What the live view knows, for the state of shuttles and rides; only now or not now, so that it changes rarely. */
export const knowledge = computed<Knowledge>(() => {
  const known_ms = link.value?.scene.value?.at_ms ?? 0;
  return { now_ms: known_ms, known_ms, is_cut_off: is_stale.value };
});

/** Requests as they were before they were sent: one that needs the second factor is sent again. */
const changes = new Map<string, Request>();

api.use({
  onRequest: ({ request, id }) => {
    const token = session.peek()?.csrf_token;
    if (token === undefined || request.method === "GET") return request;
    request.headers.set("X-CSRF-Token", token);
    changes.set(id, request.clone());
    return request;
  },
  onResponse: async ({ response, id }) => {
    const change = changes.get(id);
    changes.delete(id);
    if (response.status === 401 && session.peek() != null && !(await isWrongPassword(response)))
      setSession(null);
    if (response.status !== 403 || change === undefined) return response;
    const { code } = problemFrom(403, await response.clone().json());
    const answered = code === "second_factor_needed" && (await askSecondFactor());
    return answered ? fetch(change) : response;
  },
});

/** Asked for the password again, the operator has mistyped it: the session goes on. */
async function isWrongPassword(response: Response): Promise<boolean> {
  return problemFrom(401, await response.clone().json()).code === "wrong_credentials";
}

/** One of these roles is the operator's. */
export function may(...roles: readonly Role[]): boolean {
  const own = session.value?.roles ?? [];
  return roles.some((role) => own.includes(role));
}

/** After a reload the session's cookie may still be valid; the page cannot read it, so it asks the server. */
export async function restoreSession(): Promise<void> {
  // `campusloop view` signs its page in and says so in the address.
  const is_signed_in = new URLSearchParams(location.search).has("signed-in");
  if (localStorage.getItem(SIGNED_IN) === null && !is_signed_in) {
    setSession(null);
    return;
  }
  sessionProblem.value = null;
  const result = await resultOf(api.GET("/api/v1/session"));
  if (result.ok) setSession(result.value);
  else if (result.problem.status === 401) setSession(null);
  else sessionProblem.value = result.problem;
}

export async function signIn(name: string, password: string): Promise<Problem | null> {
  const result = await resultOf(api.POST("/api/v1/session", { body: { name, password } }));
  if (!result.ok) return result.problem;
  setSession(result.value);
  return null;
}

export async function refreshSession(): Promise<void> {
  const result = await resultOf(api.GET("/api/v1/session"));
  if (result.ok) session.value = result.value;
}

export async function signOut(): Promise<void> {
  const result = await resultOf(api.DELETE("/api/v1/session"));
  if (result.ok || result.problem.status === 401) setSession(null);
}

function setSession(next: Session | null): void {
  link.value?.close();
  link.value = next === null ? null : new LiveLink("");
  session.value = next;
  if (next === null) localStorage.removeItem(SIGNED_IN);
  else localStorage.setItem(SIGNED_IN, "yes");
}
