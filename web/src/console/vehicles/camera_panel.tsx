import { useEffect, useId, useMemo } from "preact/hooks";
import { monotonic_ms } from "../../shared/live/clock";
import type { VehicleScene } from "../../shared/scene/scene";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { CameraWatch, sourceOf } from "../onboard/shown_camera";
import { texts } from "../texts/texts";
import { RequestState } from "./request_state";

/** What a camera of the shuttle sees now, for a minute at a time. */
export function CameraPanel({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  return (
    <details class="shifts recording">
      <summary>{t.camera}</summary>
      <p class="hint">{t.show_camera_hint}</p>
      <CameraLook vehicle={vehicle} />
    </details>
  );
}

interface CameraLookProps {
  readonly vehicle: VehicleScene;
  /** Whether it is asked for without a click. */
  readonly at_once?: boolean;
}

export function CameraLook({ vehicle, at_once = false }: CameraLookProps) {
  const t = texts.value;
  const { vehicle_id } = vehicle;
  const watch = useMemo(() => new CameraWatch(vehicle_id), [vehicle_id]);
  useEffect(() => {
    if (at_once) void watch.ask();
    return () => watch.close();
  }, [watch]);
  return (
    <div>
      <RoleGate roles={["dispatcher", "safety"]}>
        <div class="line">
          <CameraChoice watch={watch} />
          <button type="button" class="button" onClick={() => void watch.ask()}>
            {watch.watching.value ? t.show_scene_again : t.show_camera}
          </button>
        </div>
      </RoleGate>
      {watch.problem.value !== null && <ProblemAlert problem={watch.problem.value} />}
      <RequestState watch={watch} connected={vehicle.facts.connected} />
      <Picture watch={watch} />
    </div>
  );
}

function CameraChoice({ watch }: { readonly watch: CameraWatch }) {
  const t = texts.value;
  const id = useId();
  const names = watch.shown.value?.picture?.cameras ?? [];
  if (names.length < 2) return null;
  return (
    <>
      <label class="visually-hidden" for={id}>
        {t.which_camera}
      </label>
      <select
        id={id}
        class="input"
        value={watch.camera.value || watch.picture?.camera}
        onChange={(event) => void watch.choose(event.currentTarget.value)}
      >
        {names.map((name) => (
          <option key={name} value={name}>
            {name}
          </option>
        ))}
      </select>
    </>
  );
}

function Picture({ watch }: { readonly watch: CameraWatch }) {
  const t = texts.value;
  // The age grows with the time of this screen.
  void monotonic_ms.value;
  const { picture } = watch;
  if (picture === null) return null;
  const source = sourceOf(picture);
  const state = picture.state ?? "no_picture";
  return (
    <figure class="camera-picture" data-state={state}>
      {source !== null && (
        <img
          src={source}
          alt={t.camera_picture_of(picture.camera)}
          data-old={watch.is_present ? undefined : ""}
        />
      )}
      {state !== "recording" && <Alert>{t.camera_states[state]}</Alert>}
      {source === null && picture.detail ? <p class="hint">{picture.detail}</p> : null}
      {source !== null && picture.coarse && <figcaption class="hint">{t.camera_coarse}</figcaption>}
    </figure>
  );
}
