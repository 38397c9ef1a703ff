import type { Signal } from "@preact/signals";
import { signal } from "@preact/signals";
import type { Problem, Result } from "../../shared/api/problem";

/** A value from the API: not loaded yet, loaded, or failed. After a failure the last value stays. */
export class Resource<T> {
  readonly value: Signal<T | null> = signal(null);
  readonly problem: Signal<Problem | null> = signal(null);
  private last_request = 0;
  private running: Promise<void> | null = null;
  private refresh_again = false;

  constructor(private readonly request: () => Promise<Result<T>>) {}

  /** Loads the value. Calls during a load cause a single further load after it. */
  refresh(): Promise<void> {
    if (this.running !== null) {
      this.refresh_again = true;
      return this.running;
    }
    this.running = this.fetch().finally(() => {
      this.running = null;
      if (this.refresh_again) {
        this.refresh_again = false;
        void this.refresh();
      }
    });
    return this.running;
  }

  clear(): void {
    this.last_request += 1;
    this.value.value = null;
    this.problem.value = null;
  }

  private async fetch(): Promise<void> {
    const request_number = (this.last_request += 1);
    const result = await this.request();
    if (request_number !== this.last_request) return;
    if (result.ok) this.value.value = result.value;
    this.problem.value = result.ok ? null : result.problem;
  }
}
