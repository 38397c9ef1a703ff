import type { Signal } from "@preact/signals";
import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { campus } from "../../shared/campus/campus";
import { fromLocalInput } from "../../shared/texts/times";
import { TextField } from "../forms/text_field";
import { closures } from "../store/closures";
import { texts } from "../texts/texts";
import { ClosureDialog } from "./closure_dialog";
import { RoadPicker } from "./road_picker";

interface ClosureFormProps {
  /** The closure that was entered last. */
  readonly entered: Signal<Schemas["ClosureView"] | null>;
}

/** Which roads are closed, why and for how long. Nothing is closed before its effects were shown. */
export function ClosureForm({ entered }: ClosureFormProps) {
  const t = texts.value;
  const chosen = useSignal<readonly string[]>([]);
  const [reason, from, until] = [useSignal(""), useSignal(""), useSignal("")];
  const asked = useSignal<Schemas["ClosureBody"] | null>(null);
  if (campus.value === null) return null;
  const ask = (event: Event) => {
    event.preventDefault();
    asked.value = {
      lane_ids: [...chosen.value],
      section_ids: [],
      reason: reason.value,
      starts_at: isoTime(from.value),
      ends_at: isoTime(until.value),
    };
  };
  return (
    <form class="grid-form" onSubmit={ask}>
      <RoadPicker campus={campus.value} chosen={chosen} />
      <TextField label={t.closure_reason} value={reason} input={{ maxLength: 200 }} />
      <TextField label={t.closure_from} value={from} input={{ type: "datetime-local" }} />
      <TextField label={t.closure_until} value={until} input={{ type: "datetime-local" }} />
      <button class="button main" disabled={chosen.value.length === 0}>
        {t.close_road_ask}
      </button>
      {asked.value !== null && (
        <ClosureDialog
          request={asked.value}
          onClose={() => {
            asked.value = null;
          }}
          onClosed={(closure) => {
            asked.value = null;
            entered.value = closure;
            chosen.value = [];
            for (const field of [reason, from, until]) field.value = "";
            void closures.refresh();
          }}
        />
      )}
    </form>
  );
}

/** The time of a field in the campus's timezone; null for an empty field. */
function isoTime(local: string): string | null {
  return fromLocalInput(local, campus.value?.view.timezone ?? "UTC")?.toISOString() ?? null;
}
