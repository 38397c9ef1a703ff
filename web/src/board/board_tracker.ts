import { computed, signal } from "@preact/signals";
import type { Schemas } from "../shared/api/client";
import { api, resultOf } from "../shared/api/client";

export type Board = Schemas["BoardView"];

/** How often the board is asked for. */
const PERIOD_MS = 5_000;
/** An answer that takes longer counts as none. */
const ANSWER_WITHIN_MS = 8_000;
/** Older news is no basis for minutes: times of the timetable are shown alone. */
const FRESH_FOR_MS = 30_000;
const STEP_MS = 1_000;

/** The board of one stop, asked for again and again, and how old it is. */
export class BoardTracker {
  readonly board = signal<Board | null>(null);
  /** The map has no such stop. */
  readonly is_unknown = signal(false);
  private readonly came_ms = signal(performance.now());
  private readonly clock_ms = signal(performance.now());

  /** The server's clock. */
  readonly now_ms = computed(() => {
    const board = this.board.value;
    return board === null ? 0 : Date.parse(board.now) + this.clock_ms.value - this.came_ms.value;
  });
  readonly is_stale = computed(() => this.clock_ms.value - this.came_ms.value > FRESH_FOR_MS);

  constructor(readonly stop_id: string) {
    window.setInterval(() => {
      this.clock_ms.value = performance.now();
    }, STEP_MS);
    void this.load();
  }

  private async load(): Promise<void> {
    const result = await resultOf(
      api.GET("/api/v1/stops/{stop_id}/board", {
        params: { path: { stop_id: this.stop_id } },
        signal: AbortSignal.timeout(ANSWER_WITHIN_MS),
      }),
    ).catch((failure: unknown) => {
      if (failure instanceof DOMException) return null;
      throw failure;
    });
    if (result?.ok) {
      this.came_ms.value = this.clock_ms.value = performance.now();
      this.board.value = result.value;
    }
    if (result !== null) this.is_unknown.value = !result.ok && result.problem.status === 404;
    window.setTimeout(() => void this.load(), PERIOD_MS);
  }
}
