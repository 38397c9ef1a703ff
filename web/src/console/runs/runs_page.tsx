import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import type { Campus } from "../../shared/campus/campus";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { runs } from "../store/runs";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { DayForm } from "./fleet/day_form";
import { RecordingList } from "./recording_list";

interface RunsPageProps {
  readonly campus: Campus;
  readonly is_link_broken?: boolean;
}

export function RunsPage({ campus, is_link_broken = false }: RunsPageProps) {
  const t = texts.value;
  const shown = runs.value.value;
  useEffect(() => void runs.refresh(), []);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.runs}</h1>
      </header>
      {is_link_broken && <Alert>{t.fleet_link_broken}</Alert>}
      <p class="hint">{t.replay_fleet_lead}</p>
      <DayForm campus={campus} />
      <RecordingList />
      {runs.problem.value !== null && <ProblemAlert problem={runs.problem.value} />}
      {shown === null && runs.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <Alert>{t.no_runs}</Alert>}
      {shown !== null && shown.length > 0 && (
        <div class="scroller">
          <table class="table">
            <thead>
              <tr>
                {[t.vehicle, t.started, t.length, t.stack, t.size].map((title) => (
                  <th key={title} scope="col">
                    {title}
                  </th>
                ))}
                <th scope="col">
                  <span class="visually-hidden">{t.replay}</span>
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
  const t = texts.value;
  const bytes = run.segments.reduce((sum, segment) => sum + segment.size_bytes, 0);
  return (
    <tr>
      <th scope="row">{vehicleName(run.vehicle_id)}</th>
      <td data-label={t.started}>{formatDateTime(run.started_at)}</td>
      <td data-label={t.length}>
        {run.segments.length === 0 ? "–" : durationText(run.duration_s)}
      </td>
      <td data-label={t.stack}>{run.stack}</td>
      <td data-label={t.size}>
        {run.segments.length === 0 ? t.not_uploaded : t.megabytes((bytes / 1e6).toFixed(1))}
      </td>
      <td>
        {run.segments.length > 0 && (
          <a class="button small" href={fragmentOf("runs", run.vehicle_id, run.boot_id)}>
            {t.replay}
          </a>
        )}
      </td>
    </tr>
  );
}

function durationText(duration_s: number): string {
  const t = texts.value;
  return duration_s < 120
    ? t.seconds(Math.round(duration_s))
    : t.minutes(Math.round(duration_s / 60));
}
