import { useSignal } from "@preact/signals";
import { api, resultOf } from "../../shared/api/client";
import { Dialog } from "../../shared/ui/dialog";
import { TextField } from "../forms/text_field";
import { link } from "../session";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";

/** One announcement to some or all shuttles. Each is a command of its own, and each has its own answer. */
export function AnnounceManyDialog({ onClose }: { readonly onClose: () => void }) {
  const t = texts.value;
  const text = useSignal("");
  const left_out = useSignal<ReadonlySet<string>>(new Set());
  const is_sending = useSignal(false);
  const sent = useSignal<{ readonly to: number; readonly failed: readonly string[] } | null>(null);
  const vehicle_ids = (link.value?.scene.value?.vehicles ?? []).map((each) => each.vehicle_id);
  const chosen = vehicle_ids.filter((vehicle_id) => !left_out.value.has(vehicle_id));
  const toggle = (vehicle_id: string) => {
    const next = new Set(left_out.value);
    if (!next.delete(vehicle_id)) next.add(vehicle_id);
    left_out.value = next;
  };
  const send = async () => {
    is_sending.value = true;
    const failed: string[] = [];
    for (const vehicle_id of chosen) {
      const result = await resultOf(
        api.POST("/api/v1/vehicles/{vehicle_id}/announce", {
          params: { path: { vehicle_id } },
          body: { text: text.value },
        }),
      );
      if (!result.ok) failed.push(vehicle_id);
    }
    is_sending.value = false;
    sent.value = { to: chosen.length - failed.length, failed };
    // What failed can be sent again without repeating it to the others.
    left_out.value = new Set(vehicle_ids.filter((vehicle_id) => !failed.includes(vehicle_id)));
    if (failed.length === 0) text.value = "";
  };
  return (
    <Dialog title={t.announce_to_shuttles} onClose={onClose}>
      <form
        class="stack"
        onSubmit={(event) => {
          event.preventDefault();
          void send();
        }}
      >
        <TextField
          label={t.announce_text}
          value={text}
          input={{ maxLength: 500, required: true }}
        />
        <fieldset class="choices">
          <legend>{t.which_shuttles}</legend>
          <label class="check">
            <input
              type="checkbox"
              checked={chosen.length === vehicle_ids.length && vehicle_ids.length > 0}
              onChange={(event) => {
                left_out.value = new Set(event.currentTarget.checked ? [] : vehicle_ids);
              }}
            />
            {t.all_shuttles}
          </label>
          {vehicle_ids.map((vehicle_id) => (
            <label key={vehicle_id} class="check">
              <input
                type="checkbox"
                checked={!left_out.value.has(vehicle_id)}
                onChange={() => toggle(vehicle_id)}
              />
              {vehicleName(vehicle_id)}
            </label>
          ))}
        </fieldset>
        <p role="status">
          {sent.value !== null && t.announced_to(sent.value.to)}
          {sent.value !== null &&
            sent.value.failed.length > 0 &&
            ` ${t.not_announced_to(sent.value.failed.map(vehicleName).join(", "))}`}
        </p>
        <div class="dialog-buttons">
          <button type="button" class="button" onClick={onClose}>
            {t.cancel}
          </button>
          <button class="button main" disabled={is_sending.value || chosen.length === 0}>
            {t.announce}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
