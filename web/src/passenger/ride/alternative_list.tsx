import { batch } from "@preact/signals";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { momentNear, toLocalInput } from "../../shared/texts/times";
import { destination, earliest, party, pickup, wheelchairs } from "../booking/ride_request";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import type { Ticket } from "./ride_tracker";

type Alternative = Ticket["alternatives"][number];

/** What could be had instead of a refused ride. A tap fills in the booking; nothing is reserved. */
export function Alternatives({
  ticket,
  campus,
}: {
  readonly ticket: Ticket;
  readonly campus: Campus;
}) {
  if (ticket.alternatives.length === 0) return null;
  return (
    <section class="alternatives">
      <h2>{texts.value.instead}</h2>
      <ul>
        {ticket.alternatives.map((one, number) => (
          <li key={number}>
            <button type="button" class="button wide" onClick={() => fillIn(one, ticket, campus)}>
              {told(one, campus)}
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}

function told(one: Alternative, campus: Campus): string {
  const t = texts.value;
  const at = one.pickup_at
    .map((time) => momentNear(Date.parse(time), Date.now(), language.value, campus.view.timezone))
    .join(t.and);
  const name = (stop_id: string) => nameOfStop(campus.shape.stops, stop_id, language.value);
  if (one.kind === "later") return t.instead_later(at);
  if (one.kind === "split_party")
    return t.instead_split(String(one.parties[0]), String(one.parties[1]), at);
  return t.instead_stops(name(one.from_stop), name(one.to_stop), at, Math.ceil(one.walk_s / 60));
}

/** The first ride of a split party; the second is booked the same way after it. */
function fillIn(one: Alternative, ticket: Ticket, campus: Campus): void {
  const first_ms = Date.parse(one.pickup_at[0] ?? ticket.earliest);
  batch(() => {
    pickup.value = one.from_stop;
    destination.value = one.to_stop;
    party.value = one.parties[0] ?? ticket.party;
    wheelchairs.value = Math.min(ticket.wheelchairs, party.value);
    earliest.value = one.kind === "later" ? toLocalInput(first_ms, campus.view.timezone) : "";
  });
  goTo({ view: "book" });
}
