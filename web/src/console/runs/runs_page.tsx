import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { Loading, Note, ProblemNote } from "../../shared/ui/notes";
import { fragmentOf } from "../place";
import { runs } from "../store/lists";
import { day } from "../texts/clocks";
import { words } from "../texts/words";

export function RunsPage() {
  const say = words.value;
  const shown = runs.value.value;
  useEffect(() => void runs.refresh(), []);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{say.runs}</h1>
      </header>
      {runs.problem.value !== null && <ProblemNote problem={runs.problem.value} />}
      {shown === null && runs.problem.value === null && <Loading text={say.loading} />}
      {shown?.length === 0 && <Note>{say.no_runs}</Note>}
      {shown !== null && shown.length > 0 && (
        <div class="scroller">
          <table class="table">
            <thead>
              <tr>
                {[say.vehicle, say.started, say.length, say.stack, say.size].map((title) => (
                  <th key={title} scope="col">
                    {title}
                  </th>
                ))}
                <th scope="col">
                  <span class="unseen">{say.replay}</span>
                </th>
              </tr>
            </thead>
            <tbody>
              {shown.map((run) => (
                <RunRow key={`${run.vehicle_id}/${run.boot_id}`} run={run} />
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}

function RunRow({ run }: { readonly run: Schemas["RunView"] }) {
  const say = words.value;
  const bytes = run.segments.reduce((sum, segment) => sum + segment.size_bytes, 0);
  return (
    <tr>
      <th scope="row">{run.vehicle_id}</th>
      <td data-label={say.started}>{day(run.started_at)}</td>
      <td data-label={say.length}>{run.segments.length === 0 ? "–" : lengthOf(run.duration_s)}</td>
      <td data-label={say.stack}>{run.stack}</td>
      <td data-label={say.size}>
        {run.segments.length === 0 ? say.not_uploaded : say.megabytes((bytes / 1e6).toFixed(1))}
      </td>
      <td>
        {run.segments.length > 0 && (
          <a class="button small" href={fragmentOf("runs", run.vehicle_id, run.boot_id)}>
            {say.replay}
          </a>
        )}
      </td>
    </tr>
  );
}

function lengthOf(duration_s: number): string {
  const say = words.value;
  return duration_s < 120
    ? say.seconds(Math.round(duration_s))
    : say.minutes(Math.round(duration_s / 60));
}
