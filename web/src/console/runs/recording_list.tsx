import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { ProblemAlert } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { recordings } from "../store/recordings";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";

/** The recordings that operators have started, newest first; nothing while there are none. */
export function RecordingList() {
  const t = texts.value;
  const shown = recordings.value.value;
  useEffect(() => void recordings.refresh(), []);
  if (recordings.problem.value !== null) return <ProblemAlert problem={recordings.problem.value} />;
  if (shown === null || shown.length === 0) return null;
  const titles = [t.recording_name, t.vehicle, t.started, t.state, t.files];
  return (
    <section class="recordings" aria-label={t.recordings}>
      <h2>{t.recordings}</h2>
      <div class="scroller">
        <table class="table">
          <thead>
            <tr>
              {titles.map((title) => (
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
            {shown.map((recording) => (
              <RecordingRow key={recording.recording_id} recording={recording} />
            ))}
          </tbody>
        </table>
      </div>
      <h2>{t.back_to_runs}</h2>
    </section>
  );
}

function RecordingRow({ recording }: { readonly recording: Schemas["RecordingView"] }) {
  const t = texts.value;
  const { name, vehicle_id, boot_id, started_at, started_by, state, segments } = recording;
  return (
    <tr>
      <th scope="row">{name}</th>
      <td data-label={t.vehicle}>{vehicleName(vehicle_id)}</td>
      <td data-label={t.started}>
        {formatDateTime(started_at)} ({started_by})
      </td>
      <td data-label={t.state}>{t.recording_states[state]}</td>
      <td data-label={t.files}>{t.recording_file_count(segments.length)}</td>
      <td>
        {segments.length > 0 && (
          <a
            class="button small"
            href={fragmentOf("runs", vehicle_id, boot_id, String(Date.parse(started_at)))}
          >
            {t.replay}
          </a>
        )}
      </td>
    </tr>
  );
}
