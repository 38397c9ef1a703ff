import type { Signal } from "@preact/signals";
import { signal } from "@preact/signals";
import type { Answer, Problem } from "../../shared/api/problem";

/** A list from the API with its states: not here yet, here, could not be had. Stale values stay visible. */
export class Fetched<T> {
  readonly value: Signal<T | null> = signal(null);
  readonly problem: Signal<Problem | null> = signal(null);
  private latest = 0;
  private running: Promise<void> | null = null;
  private again = false;

  constructor(private readonly ask: () => Promise<Answer<T>>) {}

  /** Asks now, or once more after the answer under way, however often it was called meanwhile. */
  refresh(): Promise<void> {
    if (this.running !== null) {
      this.again = true;
      return this.running;
    }
    this.running = this.fetch().finally(() => {
      this.running = null;
      if (this.again) {
        this.again = false;
        void this.refresh();
      }
    });
    return this.running;
  }

  forget(): void {
    this.latest += 1;
    this.value.value = null;
    this.problem.value = null;
  }

  private async fetch(): Promise<void> {
    const asked = (this.latest += 1);
    const answer = await this.ask();
    if (asked !== this.latest) return;
    if (answer.ok) this.value.value = answer.value;
    this.problem.value = answer.ok ? null : answer.problem;
  }
}
