import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { answerOf, api } from "../../shared/api/client";
import type { Answer, Problem } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import { stopName } from "../../shared/campus/campus_geometry";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import type { InterventionKind } from "../interventions/intervention_dialog";
import { Intervention } from "../interventions/intervention_dialog";
import { texts } from "../texts/texts";

type Command = "resume" | "stop-now" | "release" | "evacuate";

function send(vehicle_id: string, command: Command): Promise<Answer<unknown>> {
  const path = { params: { path: { vehicle_id } } };
  switch (command) {
    case "resume":
      return answerOf(api.POST("/api/v1/vehicles/{vehicle_id}/resume", path));
    case "stop-now":
      return answerOf(api.POST("/api/v1/vehicles/{vehicle_id}/stop-now", path));
    case "release":
      return answerOf(api.POST("/api/v1/vehicles/{vehicle_id}/release", path));
    case "evacuate":
      return answerOf(api.POST("/api/v1/vehicles/{vehicle_id}/evacuations", path));
  }
}

interface VehicleCommandsProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
}

export function VehicleCommands({ vehicle, scene }: VehicleCommandsProps) {
  const problem = useSignal<Problem | null>(null);
  const said = useSignal("");
  const asking = useSignal<"stop-now" | "evacuate" | InterventionKind | null>(null);
  const t = texts.value;
  const { vehicle_id, name } = vehicle;
  const finish = (answer: Answer<unknown>, text: string) => {
    problem.value = answer.ok ? null : answer.problem;
    said.value = answer.ok ? text : "";
  };
  const run = async (command: Command, title: string) =>
    finish(await send(vehicle_id, command), t.commanded(title));
  const is_held = vehicle.held || vehicle.mode !== "autonomous";
  return (
    <div class="commands">
      <div class="buttons">
        <button
          type="button"
          class={`button small ${is_held ? "main" : ""}`}
          disabled={!is_held}
          onClick={() => void run("resume", t.resume)}
        >
          {t.resume}
        </button>
        <button
          type="button"
          class="button small"
          disabled={vehicle.held}
          onClick={() => {
            asking.value = "hold";
          }}
        >
          {t.hold}
        </button>
        <button
          type="button"
          class="button small danger"
          onClick={() => {
            asking.value = "stop-now";
          }}
        >
          {t.stop_now}
        </button>
        <button
          type="button"
          class="button small"
          onClick={() => {
            asking.value = "reassign";
          }}
        >
          {t.reassign}
        </button>
        {vehicle.people_aboard > 0 && (
          <button
            type="button"
            class="button small danger"
            onClick={() => {
              asking.value = "evacuate";
            }}
          >
            {t.evacuate}
          </button>
        )}
        {vehicle.in_service ? (
          <button
            type="button"
            class="button small"
            onClick={() => {
              asking.value = "recall";
            }}
          >
            {t.recall}
          </button>
        ) : (
          <button type="button" class="button small" onClick={() => void run("release", t.release)}>
            {t.release}
          </button>
        )}
      </div>
      <Announce vehicle_id={vehicle_id} onDone={(answer) => finish(answer, t.announced)} />
      <SendToStop vehicle_id={vehicle_id} onDone={(answer) => finish(answer, t.sent)} />
      <p class="said" role="status">
        {said.value}
      </p>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {asking.value === "evacuate" && (
        <Question
          danger
          title={t.evacuate_title(name)}
          text={t.evacuate_text}
          yes={t.evacuate}
          no={t.cancel}
          onNo={() => {
            asking.value = null;
          }}
          onYes={() => {
            asking.value = null;
            void run("evacuate", t.evacuate);
          }}
        />
      )}
      {asking.value === "stop-now" && (
        <Question
          danger
          title={t.stop_now_title(name)}
          text={t.stop_now_text}
          yes={t.stop_now}
          no={t.cancel}
          onNo={() => {
            asking.value = null;
          }}
          onYes={() => {
            asking.value = null;
            void run("stop-now", t.stop_now);
          }}
        />
      )}
      {asking.value !== null && asking.value !== "stop-now" && asking.value !== "evacuate" && (
        <Intervention
          kind={asking.value}
          vehicle={vehicle}
          scene={scene}
          onDone={(answer, title) => finish(answer, t.commanded(title))}
          onClose={() => {
            asking.value = null;
          }}
        />
      )}
    </div>
  );
}

interface CommandFormProps {
  readonly vehicle_id: string;
  readonly onDone: (answer: Answer<unknown>) => void;
}

function Announce({ vehicle_id, onDone }: CommandFormProps) {
  const text = useSignal("");
  const id = useId();
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const answer = await answerOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/announce", {
        params: { path: { vehicle_id } },
        body: { text: text.value },
      }),
    );
    if (answer.ok) text.value = "";
    onDone(answer);
  };
  return (
    <form class="line" onSubmit={(event) => void submit(event)}>
      <label class="unseen" for={id}>
        {t.announce_text}
      </label>
      <input
        id={id}
        class="input"
        placeholder={t.announce_text}
        maxLength={500}
        required
        value={text.value}
        onInput={(event) => {
          text.value = event.currentTarget.value;
        }}
      />
      <button class="button">{t.announce}</button>
    </form>
  );
}

function SendToStop({ vehicle_id, onDone }: CommandFormProps) {
  const stop_id = useSignal("");
  const id = useId();
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const answer = await answerOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/send", {
        params: { path: { vehicle_id }, query: { stop_id: stop_id.value } },
      }),
    );
    if (answer.ok) stop_id.value = "";
    onDone(answer);
  };
  return (
    <form class="line" onSubmit={(event) => void submit(event)}>
      <label class="unseen" for={id}>
        {t.send}
      </label>
      <select
        id={id}
        class="input"
        required
        value={stop_id.value}
        onChange={(event) => {
          stop_id.value = event.currentTarget.value;
        }}
      >
        <option value="">{t.choose_stop}</option>
        {campus.value?.shape.stops.map((stop) => (
          <option key={stop.stop_id} value={stop.stop_id}>
            {stopName(stop, language.value)}
          </option>
        ))}
      </select>
      <button class="button">{t.go}</button>
    </form>
  );
}
