import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert } from "../../shared/ui/alerts";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { changeBetween, elementsOf } from "./drawing";
import type { EditorState } from "./editor_state";
import { MapProblemAlert } from "./map_problem_alert";

/** Two people drew on one draft: both versions are kept, and this one's drawer chooses what becomes of it. */
export function ConflictNotice({ state }: { readonly state: EditorState }) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const keepMine = async () => {
    const draft = state.draft.peek();
    if (draft === null) return;
    const made = await resultOf(
      api.POST("/api/v1/maps/drafts", {
        body: { name: t.my_version_of(draft.name), draft_id: state.draft_id },
      }),
    );
    if (!made.ok) {
      problem.value = made.problem;
      return;
    }
    // All of what is drawn here goes over what the other one left.
    const theirs = await resultOf(
      api.GET("/api/v1/maps/drafts/{draft_id}", {
        params: { path: { draft_id: made.value.draft_id } },
      }),
    );
    if (!theirs.ok) {
      problem.value = theirs.problem;
      return;
    }
    const before = elementsOf(theirs.value.elements);
    const saved = await resultOf(
      api.PATCH("/api/v1/maps/drafts/{draft_id}", {
        params: {
          path: { draft_id: made.value.draft_id },
          header: { "If-Match": made.value.revision },
        },
        body: changeBetween(before, state.elements.peek()) as never,
      }),
    );
    if (saved.ok) goTo("maps", made.value.draft_id);
    else problem.value = saved.problem;
  };
  return (
    <Alert tone="warning">
      <p>{t.draft_conflict}</p>
      <div class="buttons">
        <button type="button" class="button small main" onClick={() => void keepMine()}>
          {t.keep_my_version}
        </button>
        <button type="button" class="button small" onClick={() => void state.load()}>
          {t.load_their_version}
        </button>
      </div>
      {problem.value !== null && <MapProblemAlert problem={problem.value} />}
    </Alert>
  );
}
