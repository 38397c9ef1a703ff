import { batch, computed, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { refreshService } from "../store/service";

export type Trip = Schemas["Trip"];
export type Timetable = Schemas["TimetableView"];
export type TimetableEffect = Schemas["TimetableEffectView"];

/** The timetable while an operator changes it: nothing is in force before it is published. */
export class TimetableDraft {
  readonly trips = signal<readonly Trip[]>([]);
  readonly note = signal("");
  /** What it was made of; null before it has come. */
  readonly base = signal<Timetable | null>(null);
  /** What it would change, of the trips as they are now; null before it was asked for. */
  readonly effect = signal<TimetableEffect | null>(null);
  readonly problem = signal<Problem | null>(null);
  /** Another operator has published meanwhile. */
  readonly is_outdated = computed(() => this.problem.value?.code === "timetable_changed");
  readonly is_changed = computed(() => {
    const base = this.base.value;
    return base !== null && JSON.stringify(base.trips) !== JSON.stringify(this.trips.value);
  });

  /** What the server was asked last: an answer that comes late must not undo what a later one did. */
  private latest: Promise<unknown> = Promise.resolve();

  /** Takes over what is in force. */
  load(): Promise<void> {
    return this.inTurn(async () => {
      const result = await resultOf(api.GET("/api/v1/service/trips"));
      batch(() => {
        this.problem.value = result.ok ? null : result.problem;
        if (!result.ok) return;
        this.base.value = result.value;
        this.change(result.value.trips);
        this.note.value = "";
      });
    });
  }

  change(trips: readonly Trip[]): void {
    batch(() => {
      this.trips.value = trips;
      this.effect.value = null;
    });
  }

  /** Puts the trips of an earlier version here, to be published again. */
  take(revision: number): Promise<void> {
    return this.inTurn(async () => {
      const path = { revision };
      const result = await resultOf(
        api.GET("/api/v1/service/trips/{revision}", { params: { path } }),
      );
      if (result.ok) this.change(result.value.trips);
      else this.problem.value = result.problem;
    });
  }

  /** Keeps these trips, to be published after the other operator's version, which stays in the list. */
  keepMine(): Promise<void> {
    return this.inTurn(async () => {
      const result = await resultOf(api.GET("/api/v1/service/trips"));
      batch(() => {
        this.problem.value = result.ok ? null : result.problem;
        if (result.ok) this.base.value = result.value;
        this.effect.value = null;
      });
    });
  }

  preview(): Promise<void> {
    return this.inTurn(async () => {
      const trips = this.trips.peek();
      const result = await resultOf(
        api.POST("/api/v1/service/trips/previews", { params: this.params(), body: this.body() }),
      );
      batch(() => {
        this.problem.value = result.ok ? null : result.problem;
        // Trips that were edited meanwhile have not been looked at.
        this.effect.value = result.ok && trips === this.trips.peek() ? result.value : null;
      });
    });
  }

  /** Whether it is in force now. */
  publish(): Promise<boolean> {
    return this.inTurn(async () => {
      const result = await resultOf(
        api.PUT("/api/v1/service/trips", { params: this.params(), body: this.body() }),
      );
      if (!result.ok) {
        this.problem.value = result.problem;
        return false;
      }
      await refreshService();
      return true;
    });
  }

  private inTurn<T>(request: () => Promise<T>): Promise<T> {
    const asked = this.latest.then(request);
    this.latest = asked.catch(() => undefined);
    return asked;
  }

  private params() {
    return { header: { "If-Match": this.base.peek()?.revision ?? 0 } };
  }

  private body() {
    return { trips: this.trips.peek().map((trip) => ({ ...trip })), note: this.note.peek() };
  }
}

/** The trip in place of the one with the id `replaced`, or at the end; by the first departure. */
export function withTrip(
  trips: readonly Trip[],
  trip: Trip,
  replaced: string | null,
): readonly Trip[] {
  const others = trips.filter(({ trip_id }) => trip_id !== replaced);
  const first = ({ calls }: Trip) => calls[0]?.leaves ?? "";
  return [...others, trip].sort((one, other) => first(one).localeCompare(first(other)));
}
