import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import { conditionOf } from "../../shared/scene/condition";
import { modeOf, type Scene, type VehicleScene } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { RoleGate } from "../account/role_gate";
import type { InterventionKind } from "../interventions/intervention_dialog";
import { InterventionDialog } from "../interventions/intervention_dialog";
import { texts } from "../texts/texts";
import { AnnouncementForm } from "./announcement_form";
import { CameraLook } from "./camera_panel";
import { LastCommand } from "./last_command";
import { SendToStopForm } from "./send_to_stop_form";

type Command = "resume" | "stop-now" | "release" | "evacuate";
/** What is asked before a command is sent. */
type Question = "stop-now" | "evacuate" | "wave-on";

function send(vehicle_id: string, command: Command): Promise<Result<unknown>> {
  const path = { params: { path: { vehicle_id } } };
  switch (command) {
    case "resume":
      return resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/resume", path));
    case "stop-now":
      return resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/stop-now", path));
    case "release":
      return resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/release", path));
    case "evacuate":
      return resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/evacuations", path));
  }
}

interface VehicleCommandsProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
}

export function VehicleCommands({ vehicle, scene }: VehicleCommandsProps) {
  const problem = useSignal<Problem | null>(null);
  const outcome = useSignal("");
  const open_dialog = useSignal<Question | InterventionKind | null>(null);
  const dialog = open_dialog.value;
  const t = texts.value;
  const { vehicle_id, facts, task } = vehicle;
  const { name } = facts;
  const finish = (result: Result<unknown>, text: string) => {
    problem.value = result.ok ? null : result.problem;
    outcome.value = result.ok ? text : "";
  };
  const run = async (command: Command, title: string) =>
    finish(await send(vehicle_id, command), t.commanded(title));
  const closeDialog = () => {
    open_dialog.value = null;
  };
  const is_held = facts.held || modeOf(vehicle) !== "autonomous";
  // People who stay before a shuttle, or beside one that wants to leave, keep it standing until an operator looks.
  const waits = ["blocked", "standing"].includes(conditionOf(vehicle));
  return (
    <div class="commands">
      <RoleGate roles={["safety"]}>
        <div class="buttons">
          <button
            type="button"
            class={`button small ${is_held ? "main" : ""}`}
            disabled={!is_held && !waits}
            onClick={() => {
              if (is_held) void run("resume", t.resume);
              else open_dialog.value = "wave-on";
            }}
          >
            {t.resume}
          </button>
          <button
            type="button"
            class="button small"
            disabled={facts.held}
            onClick={() => {
              open_dialog.value = "hold";
            }}
          >
            {t.hold}
          </button>
          <button
            type="button"
            class="button small danger"
            onClick={() => {
              open_dialog.value = "stop-now";
            }}
          >
            {t.stop_now}
          </button>
          {task.people_aboard > 0 && (
            <button
              type="button"
              class="button small danger"
              onClick={() => {
                open_dialog.value = "evacuate";
              }}
            >
              {t.evacuate}
            </button>
          )}
          {facts.in_service ? (
            <button
              type="button"
              class="button small"
              onClick={() => {
                open_dialog.value = "recall";
              }}
            >
              {t.recall}
            </button>
          ) : (
            <button
              type="button"
              class="button small"
              onClick={() => void run("release", t.release)}
            >
              {t.release}
            </button>
          )}
        </div>
        <SendToStopForm vehicle_id={vehicle_id} onDone={(result) => finish(result, t.sent)} />
      </RoleGate>
      <RoleGate roles={["dispatcher"]}>
        <div class="buttons">
          <button
            type="button"
            class="button small"
            onClick={() => {
              open_dialog.value = "reassign";
            }}
          >
            {t.reassign}
          </button>
        </div>
        <AnnouncementForm
          vehicle_id={vehicle_id}
          onDone={(result) => finish(result, t.announced)}
        />
      </RoleGate>
      <p class="command-outcome" role="status">
        {outcome.value}
      </p>
      <LastCommand command={vehicle.command} />
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {dialog === "wave-on" && (
        <ConfirmDialog
          title={t.wave_on_title(name)}
          text={t.wave_on_text}
          yes={t.resume}
          no={t.cancel}
          onNo={closeDialog}
          onYes={() => {
            closeDialog();
            void run("resume", t.resume);
          }}
        >
          <CameraLook vehicle={vehicle} at_once />
        </ConfirmDialog>
      )}
      {dialog === "evacuate" && (
        <ConfirmDialog
          danger
          title={t.evacuate_title(name)}
          text={t.evacuate_text}
          yes={t.evacuate}
          no={t.cancel}
          onNo={closeDialog}
          onYes={() => {
            closeDialog();
            void run("evacuate", t.evacuate);
          }}
        />
      )}
      {dialog === "stop-now" && (
        <ConfirmDialog
          danger
          title={t.stop_now_title(name)}
          text={t.stop_now_text}
          yes={t.stop_now}
          no={t.cancel}
          onNo={closeDialog}
          onYes={() => {
            closeDialog();
            void run("stop-now", t.stop_now);
          }}
        />
      )}
      {dialog !== null &&
        dialog !== "stop-now" &&
        dialog !== "evacuate" &&
        dialog !== "wave-on" && (
          <InterventionDialog
            kind={dialog}
            vehicle={vehicle}
            scene={scene}
            onDone={(result, title) => finish(result, t.commanded(title))}
            onClose={closeDialog}
          />
        )}
    </div>
  );
}
