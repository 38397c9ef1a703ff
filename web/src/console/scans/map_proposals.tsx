import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { mapProposals } from "../store/scans";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { ProposalComparison } from "./proposal_comparison";
import { ProposalDecision } from "./proposal_decision";

/** The work tells how far it is once a second. */
const REFRESH_MS = 2_000;

/** Point maps made of scans: how far the work is, what changes, and the decision. */
export function MapProposals() {
  const t = texts.value;
  const shown = mapProposals.value.value;
  useEffect(() => {
    void mapProposals.refresh();
    const timer = window.setInterval(() => void mapProposals.refresh(), REFRESH_MS);
    return () => window.clearInterval(timer);
  }, []);
  return (
    <section class="block card">
      <h2>{t.map_proposals}</h2>
      <p class="hint">{t.map_proposals_lead}</p>
      {mapProposals.problem.value !== null && <ProblemAlert problem={mapProposals.problem.value} />}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_map_proposals}</p>}
      <ul class="rows">
        {(shown ?? []).map((proposal) => (
          <li key={proposal.proposal_id}>
            <ProposalRow proposal={proposal} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function ProposalRow({ proposal }: { readonly proposal: Schemas["ProposalView"] }) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const { state, comparison } = proposal;
  const is_under_way = state === "queued" || state === "building";
  const stop = async () => {
    const result = await resultOf(
      api.POST("/api/v1/map-proposals/{proposal_id}/stop", {
        params: { path: { proposal_id: proposal.proposal_id } },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    await mapProposals.refresh();
  };
  return (
    <>
      <div class="line">
        <span>
          <strong>{proposal.request_name}</strong>{" "}
          <span class={`chip ${state === "failed" ? "warning" : state === "ready" ? "good" : ""}`}>
            {t.proposal_states[state]}
          </span>
          <small>{formatDateTime(proposal.started_at)}</small>
          {state === "building" && (
            <small role="status">
              {t.proposal_progress(
                t.proposal_stages[proposal.stage] ?? proposal.stage,
                proposal.percent,
              )}
            </small>
          )}
          {proposal.detail !== "" && <small>{proposal.detail}</small>}
          {proposal.decided_at !== null && (
            <small>
              {t.proposal_decided(
                t.proposal_states[state],
                proposal.decided_by,
                formatDateTime(proposal.decided_at),
              )}
              {proposal.note !== "" && ` – ${proposal.note}`}
            </small>
          )}
        </span>
        {is_under_way && (
          <RoleGate roles={["dispatcher", "safety"]}>
            <button type="button" class="button small" onClick={() => void stop()}>
              {t.proposal_stop}
            </button>
          </RoleGate>
        )}
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
      </div>
      {comparison !== null && <ProposalComparison proposal={proposal} comparison={comparison} />}
      {state === "ready" && <ProposalDecision proposal={proposal} />}
    </>
  );
}
