import { useId } from "preact/hooks";
import type { Schemas } from "../shared/api/client";
import { fromLocalInput, toLocalInput } from "../shared/words/moments";
import { earliest } from "./booking_form";
import { words } from "./words";

const FIRST_CHOICE_MS = 15 * 60_000;
const PAST_MS_MAX = 60_000;

/** Now, or a time that is not over. */
export function timeIsUsable(timezone: string): boolean {
  if (earliest.value === "") return true;
  const chosen = fromLocalInput(earliest.value, timezone);
  return chosen !== null && chosen.getTime() > Date.now() - PAST_MS_MAX;
}

/** "Now", or a time on the campus's clocks. */
export function WhenField({ view }: { readonly view: Schemas["CampusView"] }) {
  const id = useId();
  const say = words.value;
  const is_later = earliest.value !== "";
  const input = (moment_ms: number) => toLocalInput(moment_ms, view.timezone);
  const chooseLater = () => {
    if (!is_later) earliest.value = input(Date.now() + FIRST_CHOICE_MS);
  };
  return (
    <fieldset class="when">
      <legend>{say.when}</legend>
      <div class="switch">
        <button
          type="button"
          aria-pressed={!is_later}
          onClick={() => {
            earliest.value = "";
          }}
        >
          {say.now}
        </button>
        <button type="button" aria-pressed={is_later} onClick={chooseLater}>
          {say.later}
        </button>
      </div>
      {is_later && (
        <div class="field">
          <label for={id}>{say.earliest_pickup}</label>
          <input
            id={id}
            class="input"
            type="datetime-local"
            required
            min={input(Date.now())}
            max={input(Date.now() + view.booking_ahead_s_max * 1000)}
            value={earliest.value}
            onChange={(event) => {
              const chosen = event.currentTarget.value;
              if (chosen !== "") earliest.value = chosen;
            }}
          />
          {!timeIsUsable(view.timezone) && (
            <p class="wrong" role="alert">
              {say.time_invalid}
            </p>
          )}
        </div>
      )}
    </fieldset>
  );
}
