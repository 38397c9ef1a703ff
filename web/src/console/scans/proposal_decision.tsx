import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { RoleGate } from "../account/role_gate";
import { TextField } from "../forms/text_field";
import { localizationMaps } from "../store/maps";
import { mapProposals } from "../store/scans";
import { texts } from "../texts/texts";

/** Publishes or dismisses a proposed map, with a note. */
export function ProposalDecision({ proposal }: { readonly proposal: Schemas["ProposalView"] }) {
  const t = texts.value;
  const asks = useSignal<"publish" | "dismiss" | null>(null);
  const note = useSignal("");
  const problem = useSignal<Problem | null>(null);
  const decide = async (event: Event) => {
    event.preventDefault();
    const options = {
      params: { path: { proposal_id: proposal.proposal_id } },
      body: { note: note.value },
    };
    const result = await resultOf(
      asks.value === "publish"
        ? api.POST("/api/v1/map-proposals/{proposal_id}/publication", options)
        : api.POST("/api/v1/map-proposals/{proposal_id}/dismissal", options),
    );
    asks.value = null;
    problem.value = result.ok ? null : result.problem;
    await mapProposals.refresh();
    await localizationMaps.refresh();
  };
  const is_publication = asks.value === "publish";
  const title = is_publication ? t.proposal_publish : t.proposal_dismiss;
  return (
    <div class="line">
      <RoleGate roles={["safety"]}>
        <button type="button" class="button main" onClick={() => (asks.value = "publish")}>
          {t.proposal_publish}
        </button>
      </RoleGate>
      <RoleGate roles={["dispatcher", "safety"]}>
        <button type="button" class="button" onClick={() => (asks.value = "dismiss")}>
          {t.proposal_dismiss}
        </button>
      </RoleGate>
      {asks.value !== null && (
        <Dialog title={title} onClose={() => (asks.value = null)}>
          <form onSubmit={(event) => void decide(event)}>
            <p>{is_publication ? t.proposal_publish_text : t.proposal_dismiss_text}</p>
            <TextField label={t.proposal_note} value={note} input={{ maxLength: 500 }} />
            <div class="dialog-buttons">
              <button type="button" class="button" onClick={() => (asks.value = null)}>
                {t.cancel}
              </button>
              <button class={`button main ${is_publication ? "" : "danger"}`}>{title}</button>
            </div>
          </form>
        </Dialog>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}
