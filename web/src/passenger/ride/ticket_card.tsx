import type { Schemas } from "../../shared/api/client";
import { DestinationMark, PickupMark } from "../../shared/ui/icons";
import { language } from "../../shared/words/language";
import { momentNear } from "../../shared/words/moments";
import { words } from "../texts/words";

interface TicketCardProps {
  readonly ticket: Schemas["RideView"] & { readonly boarding_code?: string };
  readonly vehicle: string;
  readonly from: string;
  readonly to: string;
  readonly view: Schemas["CampusView"];
  readonly ended: boolean;
}

/** What one would print: from, to, when, which shuttle, and the codes to show. */
export function TicketCard({ ticket, vehicle, from, to, view, ended }: TicketCardProps) {
  const say = words.value;
  const { promise } = ticket;
  const time = (moment: string) =>
    momentNear(moment, ticket.requested_at, language.value, view.timezone);
  return (
    <article class={`ticket card ${ended ? "ended" : ""}`}>
      <dl class="trip">
        <div>
          <dt>
            <PickupMark />
            <span class="unseen">{say.from}</span>
          </dt>
          <dd>
            {from}
            {promise !== null && (
              <small>{say.pickup_window(time(promise.pickup_from), time(promise.pickup_to))}</small>
            )}
          </dd>
        </div>
        <div>
          <dt>
            <DestinationMark />
            <span class="unseen">{say.to}</span>
          </dt>
          <dd>
            {to}
            {promise !== null && <small>{say.arrive_by(time(promise.arrive_by))}</small>}
          </dd>
        </div>
      </dl>
      <dl class="codes">
        {ticket.boarding_code !== undefined && (
          <div class="boarding">
            <dt>{say.boarding_code}</dt>
            <dd data-boarding-code>{ticket.boarding_code}</dd>
          </div>
        )}
        <div>
          <dt>{say.ride_code}</dt>
          <dd data-ride-code>{ticket.ride_code}</dd>
        </div>
      </dl>
      {ticket.boarding_code !== undefined && !ended && <p class="hint">{say.boarding_code_hint}</p>}
      <p class="stub">
        <span>{vehicle}</span>
        <span>
          {say.party(ticket.party)}
          {ticket.wheelchairs > 0 && `, ${say.party_wheelchairs(ticket.wheelchairs)}`}
        </span>
      </p>
    </article>
  );
}
