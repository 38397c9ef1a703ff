import { signal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import { idempotencyKey } from "../../shared/api/idempotency_key";

const RETRY_MS = 4_000;
const PREFIX = "campusloop.cancel.";

/** Cancels with this key. Returns the problem, or null. */
export type Deliver = (key: string) => Promise<Problem | null>;

/**
 * A cancellation that the passenger has asked for and the server has not answered. It is kept on the phone, and
 * delivered as soon as there is a connection: also after the page was closed.
 */
export class PendingCancel {
  readonly is_waiting = signal(false);
  /** Why a cancellation that was delivered later did not happen. */
  readonly refusal = signal<Problem | null>(null);
  private timer = 0;
  private is_closed = false;
  private readonly name: string;
  private readonly on_online = () => void this.deliverAgain();

  constructor(
    token: string,
    private readonly deliver: Deliver,
  ) {
    this.name = `${PREFIX}${token}`;
    window.addEventListener("online", this.on_online);
    if (localStorage.getItem(this.name) !== null) {
      this.is_waiting.value = true;
      void this.deliverAgain();
    }
  }

  close(): void {
    this.is_closed = true;
    clearTimeout(this.timer);
    window.removeEventListener("online", this.on_online);
  }

  /** The problem if the server refused it; null if it was cancelled, or waits for a connection. */
  async ask(): Promise<Problem | null> {
    this.refusal.value = null;
    const key = localStorage.getItem(this.name) ?? idempotencyKey();
    localStorage.setItem(this.name, key);
    return this.attempt(key);
  }

  /** The passenger keeps the ride after all. An attempt that is under way may still arrive. */
  withdraw(): void {
    clearTimeout(this.timer);
    this.forget();
  }

  private async attempt(key: string): Promise<Problem | null> {
    const problem = await this.deliver(key);
    if (this.is_closed || localStorage.getItem(this.name) === null) return null;
    if (problem !== null && mayCome(problem)) {
      this.is_waiting.value = true;
      clearTimeout(this.timer);
      this.timer = window.setTimeout(() => void this.deliverAgain(), RETRY_MS);
      return null;
    }
    this.forget();
    return problem;
  }

  private async deliverAgain(): Promise<void> {
    const key = localStorage.getItem(this.name);
    // Delivered or withdrawn meanwhile, perhaps by another page.
    if (key === null) this.is_waiting.value = false;
    else if (!this.is_closed) this.refusal.value = await this.attempt(key);
  }

  private forget(): void {
    localStorage.removeItem(this.name);
    this.is_waiting.value = false;
  }
}

/** Deliver what a page that is closed by now has kept. `deliver` cancels the ride of a token. */
export function deliverKept(
  deliver: (token: string, key: string) => Promise<Problem | null>,
): void {
  const tokens = Object.keys(localStorage)
    .filter((name) => name.startsWith(PREFIX))
    .map((name) => name.slice(PREFIX.length));
  for (const token of tokens) new PendingCancel(token, (key) => deliver(token, key));
}

function mayCome(problem: Problem): boolean {
  return problem.code === "offline" || problem.status >= 500 || problem.status === 429;
}
