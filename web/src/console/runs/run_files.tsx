import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import { formatTime } from "../texts/times";

interface RunFilesProps {
  readonly vehicle_id: string;
  readonly boot_id: string;
}

/** The files of a run as the vehicle wrote them: Foxglove opens them as they are. */
export function RunFiles({ vehicle_id, boot_id }: RunFilesProps) {
  const t = texts.value;
  const run = useSignal<Schemas["RunView"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  useEffect(() => {
    const path = { vehicle_id, boot_id };
    void resultOf(api.GET("/api/v1/runs/{vehicle_id}/{boot_id}", { params: { path } })).then(
      (result) => {
        if (result.ok) run.value = result.value;
        else problem.value = result.problem;
      },
    );
  }, [vehicle_id, boot_id]);
  return (
    <section class="block" aria-label={t.run_files}>
      <h2>{t.run_files}</h2>
      <p class="hint">{t.run_files_hint}</p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      <ul class="plain">
        {run.value?.segments.map((segment) => (
          <li key={segment.sha256}>
            <a class="button quiet small" href={`/api/v1/runs/segments/${segment.sha256}`} download>
              {t.run_file(
                segment.number + 1,
                formatTime(segment.received_at),
                (segment.size_bytes / 1e6).toFixed(1),
              )}
            </a>
          </li>
        ))}
      </ul>
    </section>
  );
}
