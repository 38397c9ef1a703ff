import type { Schemas } from "../../shared/api/client";
import { withNames } from "../texts/names";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";

/** All that has happened to the ride, in its order. */
export function RideHistory({
  history,
}: {
  readonly history: readonly Schemas["RideEventView"][];
}) {
  const t = texts.value;
  return (
    <section>
      <h2>{t.history}</h2>
      {history.length === 0 && <p class="empty">{t.no_history}</p>}
      <ol class="history">
        {history.map((event, index) => (
          <li key={index}>
            <time>{formatDateTime(event.happened_at)}</time>
            <span>
              <strong>{t.ride_events[event.name] ?? event.name}</strong>
              {event.by !== "" && ` · ${t.actors[event.by] ?? withNames(event.by)}`}
              {event.detail !== "" && <small> {withNames(event.detail)}</small>}
            </span>
          </li>
        ))}
      </ol>
    </section>
  );
}
