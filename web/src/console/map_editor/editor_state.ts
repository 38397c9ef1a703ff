import { batch, computed, signal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Point } from "../../shared/scene/scene";
import type { Change, Elements, Kind } from "./drawing";
import { changeBetween, elementsOf, isEmpty, NOTHING } from "./drawing";

export type Draft = Schemas["DraftView"];
export type MapProblem = Schemas["MapProblem"];

/** What is chosen on the map. */
export interface Chosen {
  readonly kind: Kind;
  readonly id: string;
}

const CHECK_AFTER_MS = 400;
const UNDO_MAX = 100;

/** One draft on the screen. Every step is sent at once; undo and redo are steps too, so that nothing is lost. */
export class EditorState {
  readonly draft = signal<Draft | null>(null);
  readonly elements = signal<Elements>(NOTHING);
  readonly buildings = signal<readonly (readonly Point[])[]>([]);
  /** The drawing while something is dragged; null: nothing is. */
  readonly preview = signal<Elements | null>(null);
  readonly chosen = signal<Chosen | null>(null);
  readonly problem = signal<Problem | null>(null);
  /** Someone else has changed the draft: what was drawn since is only here. */
  readonly conflict = signal(false);
  readonly saving = signal(false);
  readonly checking = signal(false);
  readonly found = signal<Schemas["DraftProblems"] | null>(null);
  readonly can_undo = computed(() => this.past.value.length > 0);
  readonly can_redo = computed(() => this.future.value.length > 0);
  private readonly past = signal<readonly Elements[]>([]);
  private readonly future = signal<readonly Elements[]>([]);
  private saved: Elements = NOTHING;
  private queue: Promise<void> = Promise.resolve();
  private check_timer = 0;

  constructor(readonly draft_id: string) {}

  /** Loads the draft as the server has it; what was not saved is given up. */
  async load(): Promise<void> {
    const result = await resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}", { params: { path: { draft_id: this.draft_id } } }),
    );
    if (!result.ok) {
      this.problem.value = result.problem;
      return;
    }
    batch(() => {
      this.draft.value = result.value.draft;
      this.elements.value = elementsOf(result.value.elements);
      this.buildings.value = result.value.buildings as unknown as readonly Point[][];
      this.past.value = [];
      this.future.value = [];
      this.conflict.value = false;
      this.problem.value = null;
    });
    this.saved = this.elements.peek();
    void this.check();
  }

  /** A step of drawing: shown at once, then saved. */
  draw(next: Elements): void {
    if (next === this.elements.peek()) return;
    batch(() => {
      this.past.value = [...this.past.value, this.elements.value].slice(-UNDO_MAX);
      this.future.value = [];
      this.elements.value = next;
    });
    void this.save();
  }

  undo(): void {
    const last = this.past.peek().at(-1);
    if (last === undefined) return;
    batch(() => {
      this.future.value = [...this.future.value, this.elements.value];
      this.past.value = this.past.value.slice(0, -1);
      this.elements.value = last;
    });
    void this.save();
  }

  redo(): void {
    const next = this.future.peek().at(-1);
    if (next === undefined) return;
    batch(() => {
      this.past.value = [...this.past.value, this.elements.value];
      this.future.value = this.future.value.slice(0, -1);
      this.elements.value = next;
    });
    void this.save();
  }

  /** Saves what is drawn, one request after the other. */
  save(): Promise<void> {
    this.queue = this.queue.then(() => this.send());
    return this.queue;
  }

  /** Lets the server mend a problem; the step can be undone like any other. */
  async mend(problem: MapProblem): Promise<void> {
    await this.save();
    const draft = this.draft.peek();
    if (draft === null || this.conflict.peek()) return;
    this.saving.value = true;
    const result = await resultOf(
      api.POST("/api/v1/maps/drafts/{draft_id}/fixes", {
        params: {
          path: { draft_id: this.draft_id },
          header: { "If-Match": draft.revision },
        },
        body: { defect: problem.defect, where: problem.where },
      }),
    );
    this.saving.value = false;
    this.answered(result);
    if (result.ok) await this.loadMended();
  }

  async check(): Promise<void> {
    this.checking.value = true;
    const result = await resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}/problems", {
        params: { path: { draft_id: this.draft_id } },
      }),
    );
    this.checking.value = false;
    if (!result.ok) this.problem.value = result.problem;
    else if (result.value.revision === this.draft.peek()?.revision)
      this.found.value = result.value as unknown as Schemas["DraftProblems"];
    else this.checkSoon();
  }

  private async send(): Promise<void> {
    const next = this.elements.peek();
    const draft = this.draft.peek();
    const change: Change = changeBetween(this.saved, next);
    if (draft === null || isEmpty(change) || this.conflict.peek()) return;
    this.saving.value = true;
    const result = await resultOf(
      api.PATCH("/api/v1/maps/drafts/{draft_id}", {
        params: {
          path: { draft_id: this.draft_id },
          header: { "If-Match": draft.revision },
        },
        body: change as Schemas["ChangeBody"],
      }),
    );
    this.saving.value = false;
    if (result.ok) this.saved = next;
    this.answered(result);
    if (result.ok) this.checkSoon();
  }

  private answered(result: { ok: true; value: Draft } | { ok: false; problem: Problem }): void {
    if (result.ok) {
      this.draft.value = result.value;
      this.problem.value = null;
      return;
    }
    this.conflict.value = result.problem.code === "draft_changed";
    this.problem.value = result.problem;
  }

  private async loadMended(): Promise<void> {
    const result = await resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}", { params: { path: { draft_id: this.draft_id } } }),
    );
    if (!result.ok) {
      this.problem.value = result.problem;
      return;
    }
    batch(() => {
      this.past.value = [...this.past.value, this.elements.value].slice(-UNDO_MAX);
      this.future.value = [];
      this.elements.value = elementsOf(result.value.elements);
      this.draft.value = result.value.draft;
    });
    this.saved = this.elements.peek();
    await this.check();
  }

  private checkSoon(): void {
    clearTimeout(this.check_timer);
    this.check_timer = window.setTimeout(() => void this.check(), CHECK_AFTER_MS);
  }
}
