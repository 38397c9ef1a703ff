import { useSignal } from "@preact/signals";
import { useEffect, useId, useMemo } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Answer } from "../../shared/api/problem";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { Loading, ProblemNote } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { Fetched } from "../store/resource";
import { texts } from "../texts/texts";
import { EffectsList } from "./effect_list";

export type InterventionKind = Schemas["InterventionWish"]["kind"];
type Wish = Schemas["InterventionWish"];

const HOLD_MINUTES = [2, 5, 10, 30, 60];

interface InterventionProps {
  readonly kind: InterventionKind;
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  readonly onDone: (answer: Answer<unknown>, title: string) => void;
  readonly onClose: () => void;
}

function carryOut(vehicle_id: string, wish: Wish): Promise<Answer<unknown>> {
  const path = { vehicle_id };
  switch (wish.kind) {
    case "hold":
      return answerOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/hold", {
          params: { path, query: wish.for_s == null ? {} : { for_s: wish.for_s } },
        }),
      );
    case "recall":
      return answerOf(api.POST("/api/v1/vehicles/{vehicle_id}/recall", { params: { path } }));
    case "reassign":
      return answerOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/reassign", {
          params: { path },
          body: { ride_id: wish.ride_id ?? "", to_vehicle_id: wish.to_vehicle_id ?? "" },
        }),
      );
  }
}

/** Hold, recall or reassign: whom it would delay by how much is shown before anything is done. */
export function Intervention({ kind, vehicle, scene, onDone, onClose }: InterventionProps) {
  const t = texts.value;
  const { vehicle_id, name } = vehicle;
  const wish = useSignal<Wish>({ kind, for_s: null, ride_id: "", to_vehicle_id: "" });
  const preview = useMemo(
    () =>
      new Fetched(() =>
        answerOf(
          api.POST("/api/v1/vehicles/{vehicle_id}/previews", {
            params: { path: { vehicle_id } },
            body: wish.peek(),
          }),
        ),
      ),
    [vehicle_id, wish],
  );
  useEffect(() => {
    preview.forget();
    void preview.refresh();
  }, [preview, wish.value]);
  const change = (part: Partial<Wish>) => {
    wish.value = { ...wish.value, ...part };
  };
  const titles: Record<InterventionKind, readonly [string, string, string]> = {
    hold: [t.hold_title(name), t.hold_text, t.hold],
    recall: [t.recall_title(name), t.recall_text, t.recall],
    reassign: [t.reassign_title(name), t.reassign_text, t.reassign],
  };
  const [title, text, yes] = titles[kind];
  const effects = preview.value.value;
  return (
    <Dialog title={title} onClose={onClose}>
      <p>{text}</p>
      {kind === "hold" && <HoldLength wish={wish.value} change={change} />}
      {kind === "reassign" && (
        <WhichRides wish={wish.value} change={change} vehicle={vehicle} scene={scene} />
      )}
      <h3>{t.preview}</h3>
      {preview.problem.value !== null && <ProblemNote problem={preview.problem.value} />}
      {effects === null && preview.problem.value === null && <Loading text={t.loading} />}
      {effects !== null && <EffectsList effects={effects} scene={scene} />}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cancel}
        </button>
        <button
          type="button"
          class="button main danger"
          onClick={() => {
            onClose();
            void carryOut(vehicle_id, wish.value).then((answer) => onDone(answer, yes));
          }}
        >
          {yes}
        </button>
      </div>
    </Dialog>
  );
}

interface ChoiceProps {
  readonly wish: Wish;
  readonly change: (part: Partial<Wish>) => void;
}

function HoldLength({ wish, change }: ChoiceProps) {
  const t = texts.value;
  return (
    <Choice
      label={t.hold_length}
      value={wish.for_s == null ? "" : String(wish.for_s)}
      options={[
        ["", t.until_resumed],
        ...HOLD_MINUTES.map((minutes) => [String(minutes * 60), t.minutes(minutes)] as const),
      ]}
      onChange={(value) => change({ for_s: value === "" ? null : Number(value) })}
    />
  );
}

function WhichRides({
  wish,
  change,
  vehicle,
  scene,
}: ChoiceProps & { readonly vehicle: VehicleScene; readonly scene: Scene }) {
  const t = texts.value;
  const waiting = scene.rides.filter(
    (ride) => ride.vehicle_id === vehicle.vehicle_id && ride.state === "assigned",
  );
  const others = scene.vehicles.filter((other) => other.vehicle_id !== vehicle.vehicle_id);
  return (
    <>
      <Choice
        label={t.which_rides}
        value={wish.ride_id ?? ""}
        options={[
          ["", t.all_waiting],
          ...waiting.map((ride) => [ride.ride_id, ride.ride_code] as const),
        ]}
        onChange={(ride_id) => change({ ride_id })}
      />
      <Choice
        label={t.to_vehicle}
        value={wish.to_vehicle_id ?? ""}
        options={[
          ["", t.any_other],
          ...others.map((other) => [other.vehicle_id, other.name] as const),
        ]}
        onChange={(to_vehicle_id) => change({ to_vehicle_id })}
      />
    </>
  );
}

interface SelectProps {
  readonly label: string;
  readonly value: string;
  readonly options: readonly (readonly [string, string])[];
  readonly onChange: (value: string) => void;
}

function Choice({ label, value, options, onChange }: SelectProps) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <select
        id={id}
        class="input"
        value={value}
        onChange={(event) => onChange(event.currentTarget.value)}
      >
        {options.map(([key, text]) => (
          <option key={key} value={key}>
            {text}
          </option>
        ))}
      </select>
    </div>
  );
}
