import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { texts } from "../texts/texts";
import type { LastTrip } from "./last_trips";
import { lastTrips } from "./last_trips";

interface LastTripListProps {
  readonly campus: Campus;
  readonly disabled: boolean;
  readonly onBook: (trip: LastTrip) => void;
}

/** What was booked before, each booked again by one tap. */
export function LastTripList({ campus, disabled, onBook }: LastTripListProps) {
  const t = texts.value;
  const has = (stop_id: string) => campus.stops.some((stop) => stop.stop_id === stop_id);
  const shown = lastTrips.value.filter((trip) => has(trip.from) && has(trip.to));
  if (shown.length === 0) return null;
  const name = (stop_id: string) => stopNameById(campus.stops, stop_id, language.value);
  return (
    <section class="last-trips" aria-label={t.book_again}>
      <h2>{t.book_again}</h2>
      <ul>
        {shown.map((trip) => (
          <li key={`${trip.from} ${trip.to}`}>
            <button
              type="button"
              class="button wide"
              disabled={disabled}
              onClick={() => onBook(trip)}
            >
              {t.trip_now(name(trip.from), name(trip.to), trip.party)}
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}
