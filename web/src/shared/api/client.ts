import createClient from "openapi-fetch";
import type { Answer } from "./problem";
import { OFFLINE, problemFrom } from "./problem";
import type { components, paths } from "./schema";

export type Schemas = components["schemas"];

export const api = createClient<paths>();

interface Reply<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** A call's value or its problem, so that no page has to catch anything. */
export async function answerOf<T>(call: Promise<Reply<T>>): Promise<Answer<T>> {
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
