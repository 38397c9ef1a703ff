import { serverNow_ms } from "../../shared/api/server_time";
import { batch, useSignal } from "@preact/signals";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { formatTimeOrDateTime, toLocalInput } from "../../shared/texts/times";
import {
  bookRide,
  destination,
  earliest,
  party,
  pickup,
  wheelchairs,
} from "../booking/ride_request";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { storeRideToken } from "../token_storage";
import type { Ticket } from "./ride_tracker";

type Alternative = Ticket["alternatives"][number];

/** Rides that the server offers instead of a refused one. A tap books one. For two shuttles it fills in the first half. */
export function AlternativeList({
  ticket,
  campus,
}: {
  readonly ticket: Ticket;
  readonly campus: Campus;
}) {
  const is_booking = useSignal(false);
  if (ticket.alternatives.length === 0) return null;
  const book = async (alternative: Alternative) => {
    fillAlternative(alternative, ticket, campus);
    if (alternative.kind === "split_party") {
      goTo({ view: "book" });
      return;
    }
    is_booking.value = true;
    // Between the offer and the tap, another passenger may have got the place: then the form shows what was asked.
    const result = await bookRide(campus.view.timezone);
    is_booking.value = false;
    if (!result.ok) goTo({ view: "book" });
    else {
      if (result.value.state !== "refused") storeRideToken(result.value.token);
      goTo({ view: "ride", token: result.value.token });
    }
  };
  return (
    <section class="alternatives">
      <h2>{texts.value.alternatives}</h2>
      <ul>
        {ticket.alternatives.map((alternative, number) => (
          <li key={number}>
            <button
              type="button"
              class="button wide"
              disabled={is_booking.value}
              onClick={() => void book(alternative)}
            >
              {alternativeText(alternative, campus)}
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}

function alternativeText(alternative: Alternative, campus: Campus): string {
  const t = texts.value;
  const at = alternative.pickup_at
    .map((time) =>
      formatTimeOrDateTime(Date.parse(time), serverNow_ms(), language.value, campus.view.timezone),
    )
    .join(t.and);
  const name = (stop_id: string) => stopNameById(campus.stops, stop_id, language.value);
  if (alternative.kind === "later") return t.alternative_later(at);
  if (alternative.kind === "split_party")
    return t.alternative_split(String(alternative.parties[0]), String(alternative.parties[1]), at);
  return t.alternative_stops(
    name(alternative.from_stop),
    name(alternative.to_stop),
    at,
    Math.ceil(alternative.walk_s / 60),
  );
}

/** Fills in the alternative; of a split party the first ride, after which the passenger books the second. */
function fillAlternative(alternative: Alternative, ticket: Ticket, campus: Campus): void {
  const first_ms = Date.parse(alternative.pickup_at[0] ?? ticket.earliest);
  batch(() => {
    pickup.value = alternative.from_stop;
    destination.value = alternative.to_stop;
    party.value = alternative.parties[0] ?? ticket.party;
    wheelchairs.value = Math.min(ticket.wheelchairs, party.value);
    earliest.value =
      alternative.kind === "later" ? toLocalInput(first_ms, campus.view.timezone) : "";
  });
}
