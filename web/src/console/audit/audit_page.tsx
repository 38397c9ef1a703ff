import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { fragmentOf } from "../address";
import { TextField } from "../forms/text_field";
import { auditBy, auditEntries } from "../store/audit";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";

type Entry = Schemas["AuditEntryView"];

/** Who did what, when and from where, newest first. */
export function AuditPage() {
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{texts.value.audit}</h1>
      </header>
      <RoleGate roles={["admin"]}>
        <AuditLog />
      </RoleGate>
    </section>
  );
}

function AuditLog() {
  const t = texts.value;
  const shown = auditEntries.value.value;
  useEffect(() => void auditEntries.refresh(), []);
  const filter = (event: Event) => {
    event.preventDefault();
    void auditEntries.refresh();
  };
  return (
    <>
      <p class="hint">{t.audit_lead}</p>
      <form class="grid-form" onSubmit={filter}>
        <TextField label={t.audit_by} value={auditBy} input={{ autocomplete: "off" }} />
        <button class="button main">{t.show}</button>
      </form>
      <Chain />
      {auditEntries.problem.value !== null && <ProblemAlert problem={auditEntries.problem.value} />}
      {shown === null && auditEntries.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <p class="empty">{t.no_entries}</p>}
      {shown !== null && shown.length > 0 && (
        <div class="table-scroll">
          <table class="table">
            <thead>
              <tr>
                <th>{t.audit_number}</th>
                <th>{t.audit_when}</th>
                <th>{t.audit_by}</th>
                <th>{t.audit_action}</th>
                <th>{t.audit_subject}</th>
                <th>{t.audit_outcome}</th>
                <th>{t.audit_address}</th>
                <th>{t.audit_command}</th>
              </tr>
            </thead>
            <tbody>
              {shown.map((entry) => (
                <EntryRow key={entry.number} entry={entry} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </>
  );
}

function EntryRow({ entry }: { readonly entry: Entry }) {
  return (
    <tr data-entry={entry.number}>
      <td>{entry.number}</td>
      <td>{formatDateTime(entry.happened_at)}</td>
      <td>{entry.by === "" ? "—" : entry.by}</td>
      <td>
        <span title={entry.detail}>{entry.action}</span>
      </td>
      <td>{entry.subject}</td>
      <td>
        <span class={`chip ${entry.outcome === "done" ? "calm" : "danger"}`}>{entry.outcome}</span>
      </td>
      <td>{entry.address}</td>
      <td>{entry.command_id !== "" && <CommandEnd number={entry.number} />}</td>
    </tr>
  );
}

/** How the command ended, and the run whose log has its CAN frames; asked for when it is wanted. */
function CommandEnd({ number }: { readonly number: number }) {
  const end = useSignal<Schemas["CommandEnd"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const follow = async () => {
    const path = { params: { path: { number } } };
    const result = await resultOf(api.GET("/api/v1/audit/{number}", path));
    problem.value = result.ok ? null : result.problem;
    end.value = result.ok ? result.value.command : null;
  };
  if (problem.value !== null) return <ProblemAlert problem={problem.value} />;
  if (end.value === null)
    return (
      <button type="button" class="button small" onClick={() => void follow()}>
        {t.follow_command}
      </button>
    );
  const { vehicle_id, boot_id, stamp_ns, state, reason } = end.value;
  return (
    <span>
      {t.command_states[state as keyof typeof t.command_states] ?? state} {reason}
      {boot_id !== null && stamp_ns !== null && (
        <a href={fragmentOf("runs", vehicle_id, boot_id)}>
          {t.in_run(boot_id, (stamp_ns / 1e9).toFixed(2))}
        </a>
      )}
    </span>
  );
}

/** Whether the chain of hashes is whole. */
function Chain() {
  const chain = useSignal<Schemas["ChainView"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const verify = async () => {
    const result = await resultOf(api.GET("/api/v1/audit/verify"));
    problem.value = result.ok ? null : result.problem;
    chain.value = result.ok ? result.value : null;
  };
  const found = chain.value;
  return (
    <>
      <p class="buttons">
        <button type="button" class="button" onClick={() => void verify()}>
          {t.verify_chain}
        </button>
      </p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {found !== null && (
        <Alert tone={found.intact ? "good" : "danger"}>
          {found.intact
            ? t.chain_intact(found.head_number)
            : t.chain_broken(found.broken_at ?? 0, found.what)}
          <p class="secret">{found.head_sha256}</p>
        </Alert>
      )}
    </>
  );
}
