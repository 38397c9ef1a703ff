import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { mapDrafts } from "../store/maps";
import { texts } from "../texts/texts";
import { MapProblemAlert } from "./map_problem_alert";

/** What the server takes; a larger file need not be sent to be refused. */
const FILE_BYTES_MAX = 64 * 1024 * 1024;

/** A file from OpenStreetMap or another editor becomes a draft. The chosen file stays chosen after a refusal. */
export function ImportForm() {
  const t = texts.value;
  const id = useId();
  const file = useSignal<File | null>(null);
  const is_sending = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const made = useSignal<Schemas["DraftView"] | null>(null);
  const is_large = (file.value?.size ?? 0) > FILE_BYTES_MAX;
  const send = async (elsewhere: boolean) => {
    const chosen = file.value;
    if (chosen === null) return;
    is_sending.value = true;
    problem.value = null;
    made.value = null;
    const result = await resultOf(
      api.POST("/api/v1/maps/drafts/files", {
        params: { query: { file_name: chosen.name, elsewhere } },
        body: chosen as unknown as string,
        bodySerializer: (body) => body as unknown as File,
        headers: { "Content-Type": "application/octet-stream" },
      }),
    );
    is_sending.value = false;
    if (result.ok) made.value = result.value;
    else problem.value = result.problem;
    await mapDrafts.refresh();
  };
  return (
    <form
      class="import-form"
      onSubmit={(event) => {
        event.preventDefault();
        void send(false);
      }}
    >
      <div class="field">
        <label for={id}>{t.map_file}</label>
        <input
          id={id}
          class="input"
          type="file"
          aria-describedby={`${id}-hint`}
          onChange={(event) => {
            file.value = event.currentTarget.files?.[0] ?? null;
            problem.value = null;
            made.value = null;
          }}
        />
        <p class="hint" id={`${id}-hint`}>
          {t.map_file_hint}
        </p>
      </div>
      <button
        type="submit"
        class="button"
        disabled={file.value === null || is_large || is_sending.value}
      >
        {is_sending.value ? t.importing_map : t.import_map}
      </button>
      {is_large && (
        <Alert tone="warning">
          {t.map_file_too_large(Math.round((file.value?.size ?? 0) / 1024 / 1024))}
        </Alert>
      )}
      {problem.value !== null && (
        <>
          <MapProblemAlert problem={problem.value} />
          {problem.value.code === "map_elsewhere" && (
            <button type="button" class="button" onClick={() => void send(true)}>
              {t.import_anyway}
            </button>
          )}
        </>
      )}
      {made.value !== null && <Imported draft={made.value} />}
    </form>
  );
}

function Imported({ draft }: { readonly draft: Schemas["DraftView"] }) {
  const t = texts.value;
  const repairs = draft.repairs ?? [];
  return (
    <Alert tone="good">
      <p>
        {t.map_imported(draft.name)} <a href={fragmentOf("maps", draft.draft_id)}>{t.open_draft}</a>
      </p>
      {repairs.length > 0 && (
        <details>
          <summary>{t.import_repairs(repairs.length)}</summary>
          <ul class="repairs">
            {repairs.map((line) => (
              <li key={line}>{line}</li>
            ))}
          </ul>
        </details>
      )}
    </Alert>
  );
}
