import { batch, computed, effect, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Answer, Problem } from "../../shared/api/problem";
import { LiveLink } from "../../shared/live/live_link";
import { storyOf } from "./ride_progress";

export type Ticket = Schemas["RideTicket"];
export type TapState = "none" | "asked" | "refused" | "unanswered";

const RETRY_MS = 4_000;
const TAP_ASK_EVERY_MS = 1_000;
const TAP_ASKS_MAX = 12;

/** One ride, followed by its link: the ticket from the API, everything that moves from the live view. */
export class FollowedRide {
  readonly ticket = signal<Ticket | null>(null);
  readonly problem = signal<Problem | null>(null);
  readonly tap = signal<TapState>("none");
  readonly help_at = signal<string | null>(null);
  readonly link: LiveLink;

  readonly live = computed(() => this.link.scene.value?.rides[0] ?? null);
  readonly vehicle = computed(() => this.link.scene.value?.vehicles[0] ?? null);
  readonly story = computed(() => {
    const ticket = this.ticket.value;
    return ticket === null ? null : storyOf(ticket, this.live.value, this.vehicle.value);
  });

  private left = false;
  /** Counts questions and changes: the answer to a question that a change has overtaken is out of date. */
  private turn = 0;
  private readonly stopWatching: () => void;

  constructor(readonly token: string) {
    this.link = new LiveLink(token);
    this.help_at.value = sessionStorage.getItem(this.helpKey());
    void this.load();
    this.stopWatching = effect(() => this.reloadWhenMovedOn());
  }

  leave(): void {
    this.left = true;
    this.stopWatching();
    this.link.leave();
  }

  async load(): Promise<void> {
    const turn = (this.turn += 1);
    const answer = await answerOf(
      api.GET("/api/v1/rides/{token}", { params: { path: { token: this.token } } }),
    );
    if (this.left || turn !== this.turn) return;
    this.take(answer);
    const may_heal =
      !answer.ok && (answer.problem.code === "offline" || answer.problem.status >= 500);
    if (may_heal) window.setTimeout(() => this.left || void this.load(), RETRY_MS);
  }

  async cancel(): Promise<Problem | null> {
    const answer = await answerOf(
      api.POST("/api/v1/rides/{token}/cancel", { params: { path: { token: this.token } } }),
    );
    if (!answer.ok) return answer.problem;
    this.turn += 1;
    this.take(answer);
    return null;
  }

  async changeDestination(to_stop: string): Promise<Problem | null> {
    const answer = await answerOf(
      api.POST("/api/v1/rides/{token}/destination", {
        params: { path: { token: this.token } },
        body: { to_stop },
      }),
    );
    if (!answer.ok) return answer.problem;
    this.turn += 1;
    this.take(answer);
    return null;
  }

  async tapAboard(): Promise<Problem | null> {
    const path = { token: this.token };
    return this.followTap(
      await answerOf(api.POST("/api/v1/rides/{token}/board", { params: { path } })),
    );
  }

  async tapOff(): Promise<Problem | null> {
    const path = { token: this.token };
    return this.followTap(
      await answerOf(api.POST("/api/v1/rides/{token}/alight", { params: { path } })),
    );
  }

  async callHelp(text: string): Promise<Problem | null> {
    const answer = await answerOf(
      api.POST("/api/v1/rides/{token}/help", {
        params: { path: { token: this.token } },
        body: { text },
      }),
    );
    if (!answer.ok) return answer.problem;
    this.help_at.value = new Date(this.link.now_ms() ?? Date.now()).toISOString();
    sessionStorage.setItem(this.helpKey(), this.help_at.value);
    return null;
  }

  private take(answer: Answer<Ticket>): void {
    batch(() => {
      if (answer.ok) this.ticket.value = answer.value;
      this.problem.value = answer.ok || this.ticket.value !== null ? null : answer.problem;
    });
  }

  /** The live view tells state and times; reasons and promises are on the ticket. */
  private reloadWhenMovedOn(): void {
    const [live, ticket] = [this.live.value, this.ticket.peek()];
    if (live === null || ticket === null) return;
    if (live.state === ticket.state && live.to_stop === ticket.to_stop) return;
    if (live.state !== ticket.state) this.tap.value = "none";
    void this.load();
  }

  /** The shuttle's yes comes as the ride's new state; its no only by asking for the tap. */
  private async followTap(answer: Answer<Schemas["TapView"]>): Promise<Problem | null> {
    if (!answer.ok) return answer.problem;
    this.tap.value = "asked";
    const path = { token: this.token, tap_id: answer.value.tap_id };
    for (let ask = 0; ask < TAP_ASKS_MAX && this.tap.value === "asked" && !this.left; ask += 1) {
      await new Promise((done) => window.setTimeout(done, TAP_ASK_EVERY_MS));
      const tap = await answerOf(
        api.GET("/api/v1/rides/{token}/taps/{tap_id}", { params: { path } }),
      );
      if (tap.ok && tap.value.state === "refused") this.tap.value = "refused";
      if (tap.ok && tap.value.state === "accepted") this.tap.value = "none";
    }
    if (this.tap.value === "asked") this.tap.value = "unanswered";
    return null;
  }

  private helpKey(): string {
    return `campusloop.help.${this.token}`;
  }
}

/** The ride in the address, or null; set by the app as the address changes. */
export const followed = signal<FollowedRide | null>(null);

export function follow(token: string | null): void {
  if ((followed.value?.token ?? null) === token) return;
  followed.value?.leave();
  followed.value = token === null ? null : new FollowedRide(token);
}
