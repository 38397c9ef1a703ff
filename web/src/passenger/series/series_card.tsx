import type { Schemas } from "../../shared/api/client";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { formatDate, weekdayName } from "../../shared/texts/times";
import { DestinationIcon, PickupIcon } from "../../shared/ui/icons";
import { texts } from "../texts/texts";

export type SeriesTicket = Schemas["SeriesTicket"];

interface SeriesCardProps {
  readonly ticket: SeriesTicket;
  readonly campus: Campus;
}

export function SeriesCard({ ticket, campus }: SeriesCardProps) {
  const t = texts.value;
  const name = (stop_id: string) => stopNameById(campus.stops, stop_id, language.value);
  const weekdays = ticket.weekdays.map((day) => weekdayName(day, language.value, "short"));
  return (
    <article class={`ticket card ${ticket.state === "active" ? "" : "ended"}`}>
      <dl class="trip">
        <div>
          <dt>
            <PickupIcon />
            <span class="visually-hidden">{t.from}</span>
          </dt>
          <dd>
            {name(ticket.from_stop)}
            <small>
              {weekdays.join(" ")} · {ticket.leave}
            </small>
          </dd>
        </div>
        <div>
          <dt>
            <DestinationIcon />
            <span class="visually-hidden">{t.to}</span>
          </dt>
          <dd>
            {name(ticket.to_stop)}
            <small>{t.series_until(formatDate(ticket.ends_on, language.value))}</small>
          </dd>
        </div>
      </dl>
      <p class="stub">
        <span>{t.party(ticket.party)}</span>
        {ticket.wheelchairs > 0 && <span>{t.party_wheelchairs(ticket.wheelchairs)}</span>}
      </p>
    </article>
  );
}
