import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import { texts } from "../texts/texts";

interface AnnouncementFormProps {
  readonly vehicle_id: string;
  readonly onDone: (result: Result<unknown>) => void;
}

export function AnnouncementForm({ vehicle_id, onDone }: AnnouncementFormProps) {
  const text = useSignal("");
  const id = useId();
  const t = texts.value;
  const submit = async (event: Event) => {
    event.preventDefault();
    const result = await resultOf(
      api.POST("/api/v1/vehicles/{vehicle_id}/announce", {
        params: { path: { vehicle_id } },
        body: { text: text.value },
      }),
    );
    if (result.ok) text.value = "";
    onDone(result);
  };
  return (
    <form class="line" onSubmit={(event) => void submit(event)}>
      <label class="visually-hidden" for={id}>
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
