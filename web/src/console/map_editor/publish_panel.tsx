import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { loadCampus } from "../../shared/campus/campus";
import { ConfirmDialog, Dialog } from "../../shared/ui/dialog";
import { RoleGate } from "../account/role_gate";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import type { Kind } from "./drawing";
import { KINDS } from "./drawing";
import type { EditorState } from "./editor_state";
import { MapProblemAlert } from "./map_problem_alert";

const IDS_SHOWN = 12;

/** What the draft changes, and putting it in force. */
export function PublishPanel({ state }: { readonly state: EditorState }) {
  const t = texts.value;
  const diff = useSignal<Schemas["MapDiff"] | null>(null);
  const asks = useSignal<"discard" | null>(null);
  const problem = useSignal<Problem | null>(null);
  const is_sending = useSignal(false);
  const path = { draft_id: state.draft_id };
  const compare = async () => {
    await state.save();
    const result = await resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}/diff", { params: { path } }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) diff.value = result.value;
  };
  const publish = async () => {
    is_sending.value = true;
    const revision = state.draft.peek()?.revision ?? 1;
    const result = await resultOf(
      api.POST("/api/v1/maps/drafts/{draft_id}/publications", {
        params: { path, header: { "If-Match": revision } },
      }),
    );
    is_sending.value = false;
    diff.value = null;
    problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    await loadCampus();
    goTo("maps");
  };
  const discard = async () => {
    asks.value = null;
    const result = await resultOf(
      api.DELETE("/api/v1/maps/drafts/{draft_id}", { params: { path } }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) goTo("maps");
  };
  const is_sound = state.found.value?.count === 0 && !state.conflict.value;
  return (
    <section class="block card">
      <h2>{t.publish_map}</h2>
      <p class="hint">{t.publish_map_lead}</p>
      <div class="buttons">
        <RoleGate roles={["safety"]}>
          <button
            type="button"
            class="button main"
            disabled={!is_sound || is_sending.value}
            onClick={() => void compare()}
          >
            {t.compare_and_publish}
          </button>
        </RoleGate>
        <button type="button" class="button small" onClick={() => (asks.value = "discard")}>
          {t.discard_draft}
        </button>
      </div>
      <p class="exports">
        {(["geojson", "lanelet2", "map"] as const).map((kind) => (
          <a key={kind} href={`/api/v1/maps/drafts/${state.draft_id}/exports/${kind}`} download>
            {t.export_as(t.map_formats[kind])}
          </a>
        ))}
      </p>
      {problem.value !== null && <MapProblemAlert problem={problem.value} />}
      {diff.value !== null && (
        <Dialog title={t.publish_map} onClose={() => (diff.value = null)}>
          <p>{t.publish_map_text}</p>
          <DiffTable diff={diff.value} />
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => (diff.value = null)}>
              {t.cancel}
            </button>
            <button
              type="button"
              class="button main"
              disabled={is_sending.value}
              onClick={() => void publish()}
            >
              {t.publish_map}
            </button>
          </div>
        </Dialog>
      )}
      {asks.value === "discard" && (
        <ConfirmDialog
          title={t.discard_draft}
          text={t.discard_draft_text}
          yes={t.discard_draft}
          no={t.cancel}
          danger
          onYes={() => void discard()}
          onNo={() => (asks.value = null)}
        />
      )}
    </section>
  );
}

function DiffTable({ diff }: { readonly diff: Schemas["MapDiff"] }) {
  const t = texts.value;
  const changed = KINDS.filter((kind) => countOf(diff, kind) > 0);
  if (changed.length === 0) return <p class="empty">{t.no_differences}</p>;
  return (
    <ul class="rows diff">
      {changed.map((kind) => {
        const { added, removed, changed: altered } = diff.kinds[kind]!;
        return (
          <li key={kind}>
            <strong>{t.element_kinds[kind]}</strong>
            {added.length > 0 && <small>{t.diff_added(added.length, few(added))}</small>}
            {removed.length > 0 && <small>{t.diff_removed(removed.length, few(removed))}</small>}
            {altered.length > 0 && <small>{t.diff_changed(altered.length, few(altered))}</small>}
          </li>
        );
      })}
    </ul>
  );
}

function countOf(diff: Schemas["MapDiff"], kind: Kind): number {
  const found = diff.kinds[kind];
  if (found === undefined) return 0;
  return found.added.length + found.removed.length + found.changed.length;
}

function few(ids: readonly string[]): string {
  return ids.slice(0, IDS_SHOWN).join(", ") + (ids.length > IDS_SHOWN ? ", …" : "");
}
