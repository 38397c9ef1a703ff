import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { VehicleScene } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { TextLineForm } from "../forms/text_line_form";
import { withNames } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTime } from "../texts/times";

type Recording = Schemas["RecordingView"];

const OPEN: ReadonlySet<Recording["state"]> = new Set(["waiting", "running"]);

/** Marks this moment of what the shuttle records, and starts and stops named recordings. */
export function RecordingPanel({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { vehicle_id, facts, command } = vehicle;
  const newest = useSignal<Recording | null>(null);
  const problem = useSignal<Problem | null>(null);
  const outcome = useSignal("");
  const load = async () => {
    const query = { vehicle_id, limit: 1 };
    const result = await resultOf(api.GET("/api/v1/recordings", { params: { query } }));
    problem.value = result.ok ? null : result.problem;
    if (result.ok) newest.value = result.value[0] ?? null;
  };
  // The shuttle's answer to a command changes the newest recording.
  useEffect(() => void load(), [vehicle_id, command?.command_id, command?.state]);
  const finish = (result: Result<unknown>, text: string) => {
    problem.value = result.ok ? null : result.problem;
    outcome.value = result.ok ? text : "";
    return result.ok;
  };
  const path = { vehicle_id };
  const mark = async (note: string) =>
    finish(
      await resultOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/marks", { params: { path }, body: { note } }),
      ),
      facts.connected ? t.marked : t.marked_out_of_reach,
    );
  const start = async (name: string) => {
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/recordings", { params: { path }, body: { name } }),
    );
    if (result.ok) newest.value = result.value;
    return finish(result, "");
  };
  const stop = async (recording_id: string) => {
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/recordings/{recording_id}/stop", {
        params: { path: { vehicle_id, recording_id } },
      }),
    );
    if (result.ok) newest.value = result.value;
    finish(result, "");
  };
  const recording = newest.value;
  const is_open = recording !== null && OPEN.has(recording.state);
  return (
    <details class="shifts recording" open={is_open}>
      <summary>{t.recording}</summary>
      <p class="hint">{t.recording_always}</p>
      <RoleGate roles={["dispatcher", "safety"]}>
        <TextLineForm label={t.mark_note} button={t.mark_now} onSubmit={mark} />
        {!is_open && (
          <TextLineForm label={t.recording_name} button={t.start_recording} onSubmit={start} />
        )}
      </RoleGate>
      {recording !== null && <RecordingLine recording={recording} connected={facts.connected} />}
      {is_open && (
        <RoleGate roles={["dispatcher", "safety"]}>
          <button
            type="button"
            class="button small"
            onClick={() => void stop(recording.recording_id)}
          >
            {t.stop_recording}
          </button>
        </RoleGate>
      )}
      <p class="command-outcome" role="status">
        {outcome.value}
      </p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </details>
  );
}

interface RecordingLineProps {
  readonly recording: Recording;
  readonly connected: boolean;
}

function RecordingLine({ recording, connected }: RecordingLineProps) {
  const t = texts.value;
  const { name, state, started_at, started_by, detail } = recording;
  const waits = state === "waiting" || state === "stopping";
  return (
    <p class="last-command">
      {t.recording_begun(name, formatTime(started_at), started_by)}:{" "}
      <strong>{t.recording_states[state]}</strong>
      {state === "refused" && detail !== "" && `: ${withNames(detail)}`}
      {waits && !connected && (
        <>
          <br />
          {t.recording_out_of_reach}
        </>
      )}
    </p>
  );
}
