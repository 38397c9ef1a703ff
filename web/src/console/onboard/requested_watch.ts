import { signal } from "@preact/signals";
import type { Problem, Result } from "../../shared/api/problem";

/** What is new comes about so often. */
const EVERY_MS = 400;
/** The shuttle shows it for so long after each request, and the page looks a little longer. */
export const SHOWN_MS = 60_000;
/** From this age on what is shown is told as old. */
export const OLD_MS = 2_000;

/** An answer of the server: what came last, when, and how the request stands. */
export interface Shown {
  readonly now_ms: number;
  readonly received_ms: number;
  readonly request: string;
  readonly detail: string;
}

export interface Shows<S extends Shown> {
  ask(): Promise<Result<unknown>>;
  newest(): Promise<Result<S>>;
}

/** What one shuttle shows on request: asks for it, and looks for more until the minute is over. */
export class RequestedWatch<S extends Shown> {
  /** What came last; null before the first answer. */
  readonly shown = signal<S | null>(null);
  readonly problem = signal<Problem | null>(null);
  /** Whether more is looked for. */
  readonly watching = signal(false);
  private until_ms = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private answered_ms = 0;

  constructor(
    private readonly shows: Shows<S>,
    private readonly now_ms: () => number = () => performance.now(),
  ) {}

  async ask(): Promise<void> {
    const result = await this.shows.ask();
    this.problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    this.until_ms = this.now_ms() + SHOWN_MS;
    if (this.watching.value) return;
    this.watching.value = true;
    void this.look();
  }

  close(): void {
    clearTimeout(this.timer);
    this.watching.value = false;
  }

  /** How old the newest is by the server's clock and the time since its answer; null without one. */
  get age_ms(): number | null {
    const { value: shown } = this.shown;
    if (shown === null || shown.received_ms === 0) return null;
    return shown.now_ms - shown.received_ms + Math.max(this.now_ms() - this.answered_ms, 0);
  }

  /** Whether what came last may be taken as the present. */
  get is_present(): boolean {
    const { age_ms } = this;
    return age_ms !== null && age_ms <= OLD_MS;
  }

  private async look(): Promise<void> {
    const result = await this.shows.newest();
    if (!this.watching.value) return;
    this.problem.value = result.ok ? null : result.problem;
    if (result.ok) {
      this.shown.value = result.value;
      this.answered_ms = this.now_ms();
    }
    if (this.now_ms() >= this.until_ms) this.watching.value = false;
    else this.timer = setTimeout(() => void this.look(), EVERY_MS);
  }
}
