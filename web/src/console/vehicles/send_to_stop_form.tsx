import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";

interface SendToStopFormProps {
  readonly vehicle_id: string;
  readonly onDone: (result: Result<unknown>) => void;
}

export function SendToStopForm({ vehicle_id, onDone }: SendToStopFormProps) {
  const stop_id = useSignal("");
  const id = useId();
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/send", {
        params: { path: { vehicle_id }, query: { stop_id: stop_id.value } },
      }),
    );
    if (result.ok) stop_id.value = "";
    onDone(result);
  };
  return (
    <form class="line" onSubmit={(event) => void submit(event)}>
      <label class="visually-hidden" for={id}>
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
        {campus.value?.geometry.stops.map((stop) => (
          <option key={stop.stop_id} value={stop.stop_id}>
            {stopName(stop.stop_id)}
          </option>
        ))}
      </select>
      <button class="button">{t.go}</button>
    </form>
  );
}
