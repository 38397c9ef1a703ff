import { signal } from "@preact/signals";
import type { Schemas } from "../shared/api/client";
import { answerOf, api } from "../shared/api/client";
import type { Problem } from "../shared/api/problem";
import { LiveLink } from "../shared/live/live_link";

type Session = Schemas["SessionView"];

const SIGNED_IN = "campusloop.signed_in";

/** undefined: not asked yet; null: signed out. */
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
    if (response.status === 401 && session.peek() != null) enter(null);
    return response;
  },
});

/** After a reload the cookie, which a page cannot see, may still open the session. */
export async function restoreSession(): Promise<void> {
  if (localStorage.getItem(SIGNED_IN) === null) {
    enter(null);
    return;
  }
  sessionProblem.value = null;
  const answer = await answerOf(api.GET("/api/v1/session"));
  if (answer.ok) enter(answer.value);
  else if (answer.problem.status === 401) enter(null);
  else sessionProblem.value = answer.problem;
}

export async function signIn(name: string, password: string): Promise<Problem | null> {
  const answer = await answerOf(api.POST("/api/v1/session", { body: { name, password } }));
  if (!answer.ok) return answer.problem;
  enter(answer.value);
  return null;
}

export async function signOut(): Promise<void> {
  const answer = await answerOf(api.DELETE("/api/v1/session"));
  if (answer.ok || answer.problem.status === 401) enter(null);
}

function enter(opened: Session | null): void {
  link.value?.leave();
  link.value = opened === null ? null : new LiveLink("");
  session.value = opened;
  if (opened === null) localStorage.removeItem(SIGNED_IN);
  else localStorage.setItem(SIGNED_IN, "yes");
}
