import type { Schemas } from "../../shared/api/client";
import { language } from "../../shared/texts/language";
import { formatTimeOrDateTime } from "../../shared/texts/times";
import { DestinationIcon, PickupIcon } from "../../shared/ui/icons";
import { texts } from "../texts/texts";

interface TicketCardProps {
  readonly ticket: Schemas["RideView"] & { readonly boarding_code?: string };
  readonly vehicle: string;
  readonly from: string;
  readonly to: string;
  readonly view: Schemas["CampusView"];
  readonly ended: boolean;
  /** Free seats beside the party; null or left out while not known. */
  readonly seats_left?: number | null | undefined;
  /** When a party that waits will arrive; null once it is on board, where the title says so. */
  readonly arrival?: ArrivalRange | null;
}

export interface ArrivalRange {
  readonly earliest_ms: number;
  readonly latest_ms: number;
}

/** A ride's stops, times, shuttle and codes. */
export function TicketCard({
  ticket,
  vehicle,
  from,
  to,
  view,
  ended,
  seats_left,
  arrival,
}: TicketCardProps) {
  const t = texts.value;
  const { promise } = ticket;
  const time = (timestamp: string | number, known_day = ticket.requested_at) =>
    formatTimeOrDateTime(timestamp, known_day, language.value, view.timezone);
  return (
    <article class={`ticket card ${ended ? "ended" : ""}`}>
      <dl class="trip">
        <div>
          <dt>
            <PickupIcon />
            <span class="visually-hidden">{t.from}</span>
          </dt>
          <dd>
            {from}
            {promise !== null && (
              <small>
                {t.pickup_window(
                  time(promise.pickup_from),
                  time(promise.pickup_to, promise.pickup_from),
                )}
              </small>
            )}
          </dd>
        </div>
        <div>
          <dt>
            <DestinationIcon />
            <span class="visually-hidden">{t.to}</span>
          </dt>
          <dd>
            {to}
            {arrival != null && promise !== null && (
              <small data-expected-arrival>
                {t.expected_arrival(
                  time(arrival.earliest_ms, promise.pickup_from),
                  time(arrival.latest_ms, promise.pickup_from),
                )}
              </small>
            )}
            {promise !== null && (
              <small>{t.arrive_by(time(promise.arrive_by, promise.pickup_from))}</small>
            )}
          </dd>
        </div>
      </dl>
      <dl class="codes">
        {ticket.boarding_code !== undefined && !ended && (
          <div class="boarding">
            <dt>{t.boarding_code}</dt>
            <dd data-boarding-code>{ticket.boarding_code}</dd>
          </div>
        )}
        <div>
          <dt>{t.ride_code}</dt>
          <dd data-ride-code>{ticket.ride_code}</dd>
        </div>
      </dl>
      {ticket.boarding_code !== undefined && !ended && <p class="hint">{t.boarding_code_hint}</p>}
      <p class="stub">
        <span>{vehicle}</span>
        <span>
          {t.party(ticket.party)}
          {ticket.wheelchairs > 0 && `, ${t.party_wheelchairs(ticket.wheelchairs)}`}
          {seats_left != null && !ended && ` · ${t.seats_left(seats_left)}`}
        </span>
      </p>
    </article>
  );
}
