import { useSignal } from "@preact/signals";
import type { Campus } from "../campus/campus";
import { language } from "../../shared/texts/language";
import { stopName } from "../../shared/campus/campus_geometry";
import { texts } from "../texts/texts";
import { canLocate, locateNearest } from "./nearest_stop";
import { canBook, chooseStop, nextEnd, pickup } from "./ride_request";

/** The stops at once, while one of the ends is still to be chosen: a tap each is all that it takes. */
export function QuickStops({ campus }: { readonly campus: Campus }) {
  const t = texts.value;
  if (canBook.value) return null;
  const end = nextEnd.value;
  const offered = campus.stops
    .filter((stop) => stop.stop_id !== pickup.value)
    .map((stop) => ({ stop_id: stop.stop_id, name: stopName(stop, language.value) }))
    .sort((a, b) => a.name.localeCompare(b.name, language.value));
  return (
    <section
      class="quick-stops"
      aria-label={end === "pickup" ? t.choose_pickup : t.choose_destination}
    >
      <h2>{end === "pickup" ? t.choose_pickup : t.choose_destination}</h2>
      {end === "pickup" && canLocate() && <NearestStopButton campus={campus} />}
      <ul>
        {offered.map(({ stop_id, name }) => (
          <li key={stop_id}>
            <button
              type="button"
              class="stop-choice button small"
              onClick={() => chooseStop(end, stop_id)}
            >
              {name}
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}

function NearestStopButton({ campus }: { readonly campus: Campus }) {
  const t = texts.value;
  const said = useSignal("");
  const locate = async () => {
    said.value = t.locating;
    const found = await locateNearest(campus.stops, campus.view.origin);
    if (found.kind === "found") chooseStop("pickup", found.stop_id);
    else said.value = found.kind === "far" ? t.too_far : t.location_unknown;
  };
  return (
    <>
      <button type="button" class="button" onClick={() => void locate()}>
        {t.nearest_stop}
      </button>
      <p class="hint" role="status">
        {said.value}
      </p>
    </>
  );
}
