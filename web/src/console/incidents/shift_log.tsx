import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { TextLineForm } from "../forms/text_line_form";
import { may } from "../session";
import { texts } from "../texts/texts";
import { NoteList } from "./note_list";

const SHOWN = 50;

/** What one shift leaves to the next. */
export function ShiftLog() {
  const t = texts.value;
  const notes = useSignal<readonly Schemas["NoteView"][]>([]);
  const problem = useSignal<Problem | null>(null);
  const load = async () => {
    const result = await resultOf(
      api.GET("/api/v1/shift-log", { params: { query: { limit: SHOWN } } }),
    );
    problem.value = result.ok ? null : result.problem;
    if (result.ok) notes.value = result.value;
  };
  useEffect(() => void load(), []);
  const write = async (text: string) => {
    const result = await resultOf(api.POST("/api/v1/shift-log", { body: { text } }));
    problem.value = result.ok ? null : result.problem;
    if (result.ok) await load();
    return result.ok;
  };
  return (
    <section class="shift-log">
      <h2>{t.shift_log}</h2>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {notes.value.length === 0 ? (
        <p class="empty">{t.shift_log_empty}</p>
      ) : (
        <NoteList notes={notes.value} titleOf={() => ""} textOf={(note) => note.text} />
      )}
      {may("dispatcher", "safety") && (
        <TextLineForm label={t.add_to_shift_log} button={t.save_note} onSubmit={write} />
      )}
    </section>
  );
}
