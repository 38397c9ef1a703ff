import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { TextLineForm } from "../forms/text_line_form";
import { may } from "../session";
import { texts } from "../texts/texts";
import { NoteList } from "./note_list";

type Note = Schemas["NoteView"];

/** What happened to an incident, with the operators' notes; loaded when it is opened. */
export function IncidentNotes({ incident_id }: { readonly incident_id: string }) {
  const t = texts.value;
  const notes = useSignal<readonly Note[] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const params = { params: { path: { incident_id } } };
  const load = async () => {
    const result = await resultOf(api.GET("/api/v1/incidents/{incident_id}/history", params));
    problem.value = result.ok ? null : result.problem;
    if (result.ok) notes.value = result.value;
  };
  const write = async (text: string) => {
    const body = { text };
    const result = await resultOf(
      api.POST("/api/v1/incidents/{incident_id}/notes", { ...params, body }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) await load();
    return result.ok;
  };
  return (
    <details
      class="notes"
      onToggle={(event) => {
        if (event.currentTarget.open) void load();
      }}
    >
      <summary>{t.notes}</summary>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {notes.value !== null && (
        <NoteList
          notes={notes.value}
          titleOf={(note) => t.incident_events[note.name] ?? note.name}
          textOf={(note) => (note.name === "incident.noted" ? note.text : "")}
        />
      )}
      {may("dispatcher", "safety") && (
        <TextLineForm label={t.add_note} button={t.save_note} onSubmit={write} />
      )}
    </details>
  );
}
