import { signal } from "@preact/signals";
import type { Schemas } from "../shared/api/client";
import { api, resultOf } from "../shared/api/client";
import type { Problem } from "../shared/api/problem";
import { LiveLink } from "../shared/live/live_link";

type Session = Schemas["SessionView"];

const SIGNED_IN = "campusloop.signed_in";

/** undefined: not known yet; null: signed out. */
export const session = signal<Session | null | undefined>(undefined);
export const sessionProblem = signal<Problem | null>(null);
export const link = signal<LiveLink | null>(null);

api.use({
  onRequest: ({ request }) => {
    const token = session.peek()?.csrf_token;
    if (token !== undefined && request.method !== "GET") request.headers.set("X-CSRF-Token", token);
    return request;
  },
  onResponse: ({ response }) => {
    if (response.status === 401 && session.peek() != null) setSession(null);
    return response;
  },
});

/** After a reload the session's cookie may still be valid; the page cannot read it, so it asks the server. */
export async function restoreSession(): Promise<void> {
  if (localStorage.getItem(SIGNED_IN) === null) {
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
