import { serverNow_ms } from "../../shared/api/server_time";
import { batch, computed, effect, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import { monotonic_ms } from "../../shared/live/clock";
import { LiveLink } from "../../shared/live/live_link";
import { idempotencyKey } from "../../shared/api/idempotency_key";
import { stored_at } from "../offline";
import { deliverKept, PendingCancel } from "./pending_cancel";
import { rideProgress } from "./ride_progress";
import { trackedRide } from "./tracked_ride";

export type Ticket = Schemas["RideTicket"];
export type TapState = "none" | "pending" | "refused" | "timed_out";

const RETRY_MS = 4_000;
const CLOCK_STEP_MS = 5_000;
const TAP_POLL_MS = 1_000;
const TAP_POLLS_MAX = 12;

/** One ride: its ticket from the API, and its state, times and shuttle from the live view. */
export class RideTracker {
  readonly ticket = signal<Ticket | null>(null);
  readonly problem = signal<Problem | null>(null);
  readonly tap = signal<TapState>("none");
  readonly help_at = signal<string | null>(null);
  readonly link: LiveLink;
  readonly pending_cancel: PendingCancel;

  readonly live = computed(() => this.link.scene.value?.rides[0] ?? null);
  readonly vehicle = computed(() => this.link.scene.value?.vehicles[0] ?? null);
  /** The server's clock, in steps: what a ride is may change without any message. */
  private readonly clock_ms = computed(() => {
    const now_ms = monotonic_ms.value > 0 ? (this.link.now_ms() ?? serverNow_ms()) : serverNow_ms();
    return Math.floor(now_ms / CLOCK_STEP_MS) * CLOCK_STEP_MS;
  });
  private readonly loaded_ms = signal<number | null>(null);
  /** When the ticket came from the server, by performance.now; null for a stored copy, which says its own time. */
  private readonly ticket_came_ms = signal<number | null>(null);
  /** When the newest news came, by performance.now; of a ticket only once the live view fails to open. */
  readonly news_came_ms = computed(
    () =>
      this.link.last_message_ms.value ??
      (this.link.is_failing.value ? this.ticket_came_ms.value : null),
  );
  /** When the newest news was true: a ticket grows old too if the live view never opens. */
  private readonly known_ms = computed(() => {
    const scene = this.link.scene.value;
    if (scene !== null) return scene.at_ms;
    return stored_at.value === null ? this.loaded_ms.value : Date.parse(stored_at.value);
  });
  readonly progress = computed(() => {
    const ticket = this.ticket.value;
    if (ticket === null) return null;
    const now_ms = this.clock_ms.value;
    const is_cut_off = this.link.state.value === "lost" || stored_at.value !== null;
    const knowledge = { now_ms, known_ms: this.known_ms.value ?? now_ms, is_cut_off };
    return rideProgress(ticket, this.live.value, this.vehicle.value, knowledge);
  });

  private closed = false;
  /** Counts loads and changes: a load that began before a change returns an outdated ticket. */
  private request_number = 0;
  private readonly stopEffect: () => void;

  constructor(readonly token: string) {
    this.link = new LiveLink(token);
    this.pending_cancel = new PendingCancel(token, (key) => this.cancel(key, true));
    this.help_at.value = sessionStorage.getItem(this.helpKey());
    void this.load();
    this.stopEffect = effect(() => {
      this.reloadOnChange();
      this.reloadCopy();
    });
  }

  close(): void {
    this.closed = true;
    this.stopEffect();
    this.link.close();
    this.pending_cancel.close();
  }

  async load(): Promise<void> {
    const request_number = (this.request_number += 1);
    const result = await resultOf(
      api.GET("/api/v1/rides/{token}", { params: { path: { token: this.token } } }),
    );
    if (this.closed || request_number !== this.request_number) return;
    this.accept(result);
    const may_recover =
      !result.ok && (result.problem.code === "offline" || result.problem.status >= 500);
    if (may_recover) window.setTimeout(() => this.closed || void this.load(), RETRY_MS);
  }

  /** Gets off early. A cancellation goes through `pending_cancel`, which keeps it until it has arrived. */
  async getOff(): Promise<Problem | null> {
    return this.cancel(idempotencyKey(), false);
  }

  private async cancel(key: string, unless_aboard: boolean): Promise<Problem | null> {
    const result = await cancelRide(this.token, key, unless_aboard);
    if (!result.ok) return result.problem;
    this.request_number += 1;
    this.accept(result);
    return null;
  }

  async changeDestination(to_stop: string): Promise<Problem | null> {
    const result = await resultOf(
      api.POST("/api/v1/rides/{token}/destination", {
        params: { path: { token: this.token } },
        body: { to_stop },
      }),
    );
    if (!result.ok) return result.problem;
    this.request_number += 1;
    this.accept(result);
    return null;
  }

  async tapAboard(): Promise<Problem | null> {
    const path = { token: this.token };
    return this.awaitTap(
      await resultOf(api.POST("/api/v1/rides/{token}/board", { params: { path } })),
    );
  }

  async tapOff(): Promise<Problem | null> {
    const path = { token: this.token };
    return this.awaitTap(
      await resultOf(api.POST("/api/v1/rides/{token}/alight", { params: { path } })),
    );
  }

  async callHelp(text: string): Promise<Problem | null> {
    const result = await resultOf(
      api.POST("/api/v1/rides/{token}/help", {
        params: { path: { token: this.token } },
        body: { text },
      }),
    );
    if (!result.ok) return result.problem;
    this.help_at.value = new Date(this.link.now_ms() ?? serverNow_ms()).toISOString();
    sessionStorage.setItem(this.helpKey(), this.help_at.value);
    return null;
  }

  /** After the ride. What is told again replaces what was told before. */
  async giveFeedback(rating: number | null, lost_property: string): Promise<Problem | null> {
    const result = await resultOf(
      api.POST("/api/v1/rides/{token}/feedback", {
        params: { path: { token: this.token } },
        body: { rating, lost_property },
      }),
    );
    return result.ok ? null : result.problem;
  }

  private accept(result: Result<Ticket>): void {
    batch(() => {
      if (result.ok) {
        this.ticket.value = result.value;
        this.loaded_ms.value = serverNow_ms();
        this.ticket_came_ms.value = stored_at.value === null ? performance.now() : null;
      }
      this.problem.value = result.ok || this.ticket.value !== null ? null : result.problem;
    });
  }

  /** The live view has the state and the times; the ticket has reasons and promises. */
  private reloadOnChange(): void {
    const [live, ticket] = [this.live.value, this.ticket.peek()];
    if (live === null || ticket === null) return;
    if (live.state === ticket.state && live.to_stop === ticket.to_stop) return;
    if (live.state !== ticket.state) this.tap.value = "none";
    void this.load();
  }

  /** A ticket that this phone had kept is loaded again as soon as the server can be heard. */
  private reloadCopy(): void {
    if (this.link.state.value === "open" && stored_at.peek() !== null) void this.load();
  }

  /** Polls the tap: the live view shows an accepted tap as the ride's new state, but not a refused one. */
  private async awaitTap(result: Result<Schemas["TapView"]>): Promise<Problem | null> {
    if (!result.ok) return result.problem;
    this.tap.value = "pending";
    const path = { token: this.token, tap_id: result.value.tap_id };
    for (
      let poll = 0;
      poll < TAP_POLLS_MAX && this.tap.value === "pending" && !this.closed;
      poll += 1
    ) {
      await new Promise((resolve) => window.setTimeout(resolve, TAP_POLL_MS));
      const tap = await resultOf(
        api.GET("/api/v1/rides/{token}/taps/{tap_id}", { params: { path } }),
      );
      if (tap.ok && tap.value.state === "refused") this.tap.value = "refused";
      if (tap.ok && tap.value.state === "accepted") this.tap.value = "none";
    }
    if (this.tap.value === "pending") this.tap.value = "timed_out";
    return null;
  }

  private helpKey(): string {
    return `campusloop.help.${this.token}`;
  }
}

/** unless_aboard: who asked for it before boarding does not want to be let out. */
function cancelRide(token: string, key: string, unless_aboard: boolean): Promise<Result<Ticket>> {
  const params = {
    path: { token },
    query: { unless_aboard },
    header: { "idempotency-key": key },
  };
  return resultOf(api.POST("/api/v1/rides/{token}/cancel", { params }));
}

/** Cancellations that an earlier visit of this page could not deliver. */
export function deliverKeptCancels(): void {
  deliverKept(async (token, key) => {
    const result = await cancelRide(token, key, true);
    return result.ok ? null : result.problem;
  });
}

/** Follows the ride of a link, or none. */
export function trackRide(token: string | null): void {
  if ((trackedRide.value?.token ?? null) === token) return;
  trackedRide.value?.close();
  trackedRide.value = token === null ? null : new RideTracker(token);
}
