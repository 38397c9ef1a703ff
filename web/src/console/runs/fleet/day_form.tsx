import { useSignal } from "@preact/signals";
import type { Campus } from "../../../shared/campus/campus";
import { TextField } from "../../forms/text_field";
import { goTo } from "../../navigation";
import { texts } from "../../texts/texts";
import { now_ms } from "../../texts/times";
import { dayAfter, dayOf, startOfDay_ms } from "./campus_day";
import { idsOfFleetReplay } from "./replay_address";

/** What came by then is stored. */
const SETTLED_MS = 5_000;

/** Chooses a day of the campus and opens the replay of the whole fleet. */
export function DayForm({ campus }: { readonly campus: Campus }) {
  const t = texts.value;
  const { timezone } = campus.view;
  const today = dayOf(now_ms(), timezone);
  const date = useSignal(today);
  const open = (event: Event) => {
    event.preventDefault();
    const start_ms = startOfDay_ms(date.value, timezone);
    const end_ms = startOfDay_ms(dayAfter(date.value), timezone);
    // Of a day that is not over the end is what one looks for.
    const at_ms = Math.max(start_ms, Math.min(end_ms, now_ms() - SETTLED_MS));
    const first_ms = date.value === today ? at_ms : start_ms;
    goTo("runs", ...idsOfFleetReplay({ start_ms, end_ms, at_ms: first_ms, vehicle_id: "" }));
  };
  return (
    <form class="row-form" onSubmit={open}>
      <TextField
        label={t.replay_day}
        value={date}
        input={{ type: "date", max: today, required: true }}
      />
      <button class="button main">{t.replay_fleet}</button>
    </form>
  );
}
