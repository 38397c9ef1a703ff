import { useSignal } from "@preact/signals";
import { campus } from "../../shared/campus/campus";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { link } from "../session";
import { EVERY_OPEN_RIDE, rides, rideSearch, searchedDay } from "../store/rides";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { dayBounds } from "./campus_day";

/** Rides by code, stop, vehicle and day. Enter searches. */
export function RideSearchForm() {
  const t = texts.value;
  const { code, stop_id, vehicle_id, day } = rideSearch.value;
  const code_field = useSignal(code);
  const day_field = useSignal(day);
  const stops = campus.value?.geometry.stops ?? [];
  const vehicles = link.value?.scene.value?.vehicles ?? [];
  const search = (changes: object) => {
    const next = {
      ...rideSearch.peek(),
      code: code_field.value.trim(),
      day: day_field.value,
      ...changes,
    };
    // What is looked for by its code or its day may be over.
    if (next.code !== "" || next.day !== "") next.open_only = false;
    rideSearch.value = next;
    const timezone = campus.value?.view.timezone ?? "UTC";
    searchedDay.value = next.day === "" ? null : dayBounds(next.day, timezone);
    rides.clear();
    void rides.refresh();
  };
  const clear = () => {
    code_field.value = "";
    day_field.value = "";
    search(EVERY_OPEN_RIDE);
  };
  return (
    <form
      class="ride-search"
      role="search"
      onSubmit={(event) => {
        event.preventDefault();
        search({});
      }}
    >
      <TextField
        label={t.ride_code}
        value={code_field}
        input={{ maxLength: 16, pattern: "[A-Za-z0-9 \\-]*", autocomplete: "off" }}
      />
      <SelectField
        label={t.stop}
        value={stop_id}
        options={[
          ["", t.any],
          ...stops.map((stop) => [stop.stop_id, stopName(stop.stop_id)] as const),
        ]}
        onChange={(chosen) => search({ stop_id: chosen })}
      />
      <SelectField
        label={t.vehicle}
        value={vehicle_id}
        options={[
          ["", t.any],
          ...vehicles.map((each) => [each.vehicle_id, each.facts.name || each.vehicle_id] as const),
        ]}
        onChange={(chosen) => search({ vehicle_id: chosen })}
      />
      <TextField label={t.day} value={day_field} input={{ type: "date" }} />
      <div class="buttons">
        <button class="button main">{t.search}</button>
        <button type="button" class="button" onClick={clear}>
          {t.clear_search}
        </button>
      </div>
    </form>
  );
}
