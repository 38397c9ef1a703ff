import createClient from "openapi-fetch";
import type { Result } from "./problem";
import { OFFLINE, problemFrom } from "./problem";
import type { components, paths } from "./schema";
import { noteSent, STORED_AT } from "./server_time";

export type Schemas = components["schemas"];

export const api = createClient<paths>();

api.use({
  onResponse({ response }) {
    if (!response.headers.has(STORED_AT)) noteSent(response.headers.get("Date"));
  },
});

interface ApiResponse<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** The value of a call or its problem, so that pages catch no exceptions. */
export async function resultOf<T>(call: Promise<ApiResponse<T>>): Promise<Result<T>> {
  try {
    const { data, error, response } = await call;
    if (response.ok) return { ok: true, value: data as T };
    return { ok: false, problem: problemFrom(response.status, error) };
  } catch (failure) {
    if (failure instanceof TypeError) return { ok: false, problem: OFFLINE };
    if (failure instanceof SyntaxError) return { ok: false, problem: problemFrom(0, null) };
    throw failure;
  }
}
