import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { Loading, ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { SelectField } from "../forms/select_field";
import { Resource } from "../store/resource";
import { texts } from "../texts/texts";
import { EffectList } from "./effect_list";

export type InterventionKind = Schemas["InterventionRequest"]["kind"];
type InterventionRequest = Schemas["InterventionRequest"];

const HOLD_MINUTES = [2, 5, 10, 30, 60];

interface InterventionDialogProps {
  readonly kind: InterventionKind;
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  readonly onDone: (result: Result<unknown>, title: string) => void;
  readonly onClose: () => void;
}

function sendIntervention(
  vehicle_id: string,
  request: InterventionRequest,
): Promise<Result<unknown>> {
  const path = { vehicle_id };
  switch (request.kind) {
    case "hold":
      return resultOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/hold", {
          params: { path, query: request.for_s == null ? {} : { for_s: request.for_s } },
        }),
      );
    case "recall":
      return resultOf(api.POST("/api/v1/vehicles/{vehicle_id}/recall", { params: { path } }));
    case "reassign":
      return resultOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/reassign", {
          params: { path },
          body: { ride_id: request.ride_id ?? "", to_vehicle_id: request.to_vehicle_id ?? "" },
        }),
      );
  }
}

/** Hold, recall or reassign: shows the delays that it would cause before the operator confirms it. */
export function InterventionDialog({
  kind,
  vehicle,
  scene,
  onDone,
  onClose,
}: InterventionDialogProps) {
  const t = texts.value;
  const { vehicle_id, facts } = vehicle;
  const { name } = facts;
  const request = useSignal<InterventionRequest>({
    kind,
    for_s: null,
    ride_id: "",
    to_vehicle_id: "",
  });
  const preview = useMemo(
    () =>
      new Resource(() =>
        resultOf(
          api.POST("/api/v1/vehicles/{vehicle_id}/previews", {
            params: { path: { vehicle_id } },
            body: request.peek(),
          }),
        ),
      ),
    [vehicle_id, request],
  );
  useEffect(() => {
    preview.clear();
    void preview.refresh();
  }, [preview, request.value]);
  const change = (changes: Partial<InterventionRequest>) => {
    request.value = { ...request.value, ...changes };
  };
  const titles: Record<InterventionKind, readonly [string, string, string]> = {
    hold: [t.hold_title(name), t.hold_text, t.hold],
    recall: [t.recall_title(name), t.recall_text, t.recall],
    reassign: [t.reassign_title(name), t.reassign_text, t.reassign],
  };
  const [title, text, confirm_text] = titles[kind];
  const effects = preview.value.value;
  return (
    <Dialog title={title} onClose={onClose}>
      <p>{text}</p>
      {kind === "hold" && <HoldDurationField request={request.value} change={change} />}
      {kind === "reassign" && (
        <ReassignmentFields
          request={request.value}
          change={change}
          vehicle={vehicle}
          scene={scene}
        />
      )}
      <h3>{t.preview}</h3>
      {preview.problem.value !== null && <ProblemAlert problem={preview.problem.value} />}
      {effects === null && preview.problem.value === null && <Loading text={t.loading} />}
      {effects !== null && <EffectList effects={effects} vehicles={scene.vehicles} />}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cancel}
        </button>
        <button
          type="button"
          class="button main danger"
          onClick={() => {
            onClose();
            void sendIntervention(vehicle_id, request.value).then((result) =>
              onDone(result, confirm_text),
            );
          }}
        >
          {confirm_text}
        </button>
      </div>
    </Dialog>
  );
}

interface InterventionFieldProps {
  readonly request: InterventionRequest;
  readonly change: (changes: Partial<InterventionRequest>) => void;
}

function HoldDurationField({ request, change }: InterventionFieldProps) {
  const t = texts.value;
  return (
    <SelectField
      label={t.hold_duration}
      value={request.for_s == null ? "" : String(request.for_s)}
      options={[
        ["", t.until_resumed],
        ...HOLD_MINUTES.map((minutes) => [String(minutes * 60), t.minutes(minutes)] as const),
      ]}
      onChange={(value) => change({ for_s: value === "" ? null : Number(value) })}
    />
  );
}

function ReassignmentFields({
  request,
  change,
  vehicle,
  scene,
}: InterventionFieldProps & { readonly vehicle: VehicleScene; readonly scene: Scene }) {
  const t = texts.value;
  const waiting = scene.rides.filter(
    (ride) => ride.vehicle_id === vehicle.vehicle_id && ride.state === "assigned",
  );
  const others = scene.vehicles.filter((other) => other.vehicle_id !== vehicle.vehicle_id);
  return (
    <>
      <SelectField
        label={t.which_rides}
        value={request.ride_id ?? ""}
        options={[
          ["", t.all_waiting],
          ...waiting.map((ride) => [ride.ride_id, ride.ride_code] as const),
        ]}
        onChange={(ride_id) => change({ ride_id })}
      />
      <SelectField
        label={t.to_vehicle}
        value={request.to_vehicle_id ?? ""}
        options={[
          ["", t.any_other],
          ...others.map((other) => [other.vehicle_id, other.facts.name] as const),
        ]}
        onChange={(to_vehicle_id) => change({ to_vehicle_id })}
      />
    </>
  );
}
