/** Why a request failed: the server's problem details (RFC 9457), or no connection. */
export interface Problem {
  readonly status: number;
  readonly code: string;
  readonly detail: string;
}

export const OFFLINE: Problem = { status: 0, code: "offline", detail: "" };

/** The problem in an error's body, also if the body is no problem details. */
export function problemFrom(status: number, body: unknown): Problem {
  if (typeof body === "object" && body !== null && "code" in body && "detail" in body)
    return { status, code: String(body.code), detail: String(body.detail) };
  return { status, code: "not_json", detail: `HTTP ${status}` };
}

export type Result<T> =
  { readonly ok: true; readonly value: T } | { readonly ok: false; readonly problem: Problem };
