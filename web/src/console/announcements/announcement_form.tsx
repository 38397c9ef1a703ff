import type { Signal } from "@preact/signals";
import { useSignal } from "@preact/signals";
import { campus } from "../../shared/campus/campus";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { link } from "../session";
import { announcements } from "../store/announcements";
import { vehicleName } from "../texts/names";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import type { AnnouncementBody, Audience } from "./announcement_draft";
import { bodyOf, TEXT_CHARACTERS_MAX } from "./announcement_draft";
import { AnnouncementPreview } from "./announcement_preview";

const AUDIENCES: readonly Audience[] = ["all", "stops", "shuttles"];

/** The text in both languages, to whom and for how long. Riders see nothing before the preview. */
export function AnnouncementForm() {
  const t = texts.value;
  const [text_zh, text_en] = [useSignal(""), useSignal("")];
  const audience = useSignal<Audience>("all");
  const chosen = useSignal<readonly string[]>([]);
  const [from, until] = [useSignal(""), useSignal("")];
  const asked = useSignal<AnnouncementBody | null>(null);
  const ask = (event: Event) => {
    event.preventDefault();
    asked.value = bodyOf(
      {
        text_zh: text_zh.value,
        text_en: text_en.value,
        audience: audience.value,
        chosen: chosen.value,
        from: from.value,
        until: until.value,
      },
      campus.value?.view.timezone ?? "UTC",
    );
  };
  const clear = () => {
    asked.value = null;
    chosen.value = [];
    for (const field of [text_zh, text_en, from, until]) field.value = "";
    void announcements.refresh();
  };
  const is_ready = text_zh.value.trim() !== "" && text_en.value.trim() !== "";
  return (
    <form class="grid-form" onSubmit={ask}>
      <BoundedText label={t.announcement_zh} value={text_zh} />
      <BoundedText label={t.announcement_en} value={text_en} />
      <SelectField
        label={t.audience}
        value={audience.value}
        options={AUDIENCES.map((each) => [each, t.audiences[each]] as const)}
        onChange={(value) => {
          audience.value = value as Audience;
          chosen.value = [];
        }}
      />
      {audience.value !== "all" && <Addressees audience={audience.value} chosen={chosen} />}
      <TextField label={t.announcement_from} value={from} input={{ type: "datetime-local" }} />
      <TextField label={t.announcement_until} value={until} input={{ type: "datetime-local" }} />
      <button class="button main" disabled={!is_ready}>
        {t.announcement_preview}
      </button>
      {asked.value !== null && (
        <AnnouncementPreview
          body={asked.value}
          onClose={() => {
            asked.value = null;
          }}
          onMade={clear}
        />
      )}
    </form>
  );
}

function BoundedText({ label, value }: { readonly label: string; readonly value: Signal<string> }) {
  const left = TEXT_CHARACTERS_MAX - value.value.length;
  return (
    <TextField
      label={label}
      value={value}
      {...(left < 60 ? { hint: texts.value.announcement_length(left) } : {})}
      input={{ maxLength: TEXT_CHARACTERS_MAX, required: true }}
    />
  );
}

interface AddresseesProps {
  readonly audience: Audience;
  readonly chosen: Signal<readonly string[]>;
}

/** Stops or shuttles; none chosen means all. */
function Addressees({ audience, chosen }: AddresseesProps) {
  const t = texts.value;
  const is_stops = audience === "stops";
  const known = is_stops
    ? (campus.value?.geometry.stops ?? []).map(({ stop_id }) => [stop_id, stopName(stop_id)])
    : (link.value?.scene.value?.vehicles ?? []).map(({ vehicle_id }) => [
        vehicle_id,
        vehicleName(vehicle_id),
      ]);
  const toggle = (id: string) => {
    const without = chosen.value.filter((each) => each !== id);
    chosen.value = without.length === chosen.value.length ? [...without, id] : without;
  };
  return (
    <fieldset class="choices">
      <legend>{is_stops ? t.which_stops : t.which_shuttles}</legend>
      <label class="check">
        <input
          type="checkbox"
          checked={chosen.value.length === 0}
          onChange={() => {
            chosen.value = [];
          }}
        />
        {is_stops ? t.every_stop : t.every_shuttle}
      </label>
      {known.map(([id = "", name]) => (
        <label key={id} class="check">
          <input type="checkbox" checked={chosen.value.includes(id)} onChange={() => toggle(id)} />
          {name}
        </label>
      ))}
    </fieldset>
  );
}
