import { computed, signal } from "@preact/signals";
import type { Schemas } from "../shared/api/client";
import { api, resultOf } from "../shared/api/client";
import { retryDelay_ms } from "../shared/live/backoff";

export type Board = Schemas["BoardView"];

/** How often the board is asked for while the server does not send it by itself. */
const PERIOD_MS = 5_000;
/** The server sends it at least every five seconds. */
const SILENT_MS = 7_000;
/** An answer that takes longer counts as none. */
const ANSWER_WITHIN_MS = 8_000;
/** Older news is no basis for minutes: times of the timetable are shown alone. */
const FRESH_FOR_MS = 30_000;
const STEP_MS = 1_000;

/** The board of one stop, sent whenever it changes or else asked for again and again, and how old it is. */
export class BoardTracker {
  readonly board = signal<Board | null>(null);
  /** The map has no such stop. */
  readonly is_unknown = signal(false);
  private readonly came_ms = signal(performance.now());
  private readonly clock_ms = signal(performance.now());
  private sent_ms = -Infinity;
  private attempt = 0;

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
    this.connect();
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const path = `/ws/board/${encodeURIComponent(this.stop_id)}`;
    const socket = new WebSocket(`${scheme}//${location.host}${path}`);
    socket.onmessage = ({ data }) => {
      this.attempt = 0;
      this.sent_ms = performance.now();
      this.take(JSON.parse(String(data)) as Board);
    };
    socket.onclose = () => {
      window.setTimeout(() => this.connect(), retryDelay_ms(this.attempt++, Math.random()));
    };
  }

  private take(board: Board): void {
    this.came_ms.value = this.clock_ms.value = performance.now();
    this.board.value = board;
  }

  /** Asks for the board, unless it comes by itself. */
  private async refresh(): Promise<void> {
    if (performance.now() - this.sent_ms > SILENT_MS) await this.load();
    else window.setTimeout(() => void this.refresh(), PERIOD_MS);
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
    if (result?.ok) this.take(result.value);
    if (result !== null) this.is_unknown.value = !result.ok && result.problem.status === 404;
    window.setTimeout(() => void this.refresh(), PERIOD_MS);
  }
}
