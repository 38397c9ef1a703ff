import { language } from "../shared/texts/language";
import { formatTime } from "../shared/texts/times";
import type { Board } from "./board_tracker";
import { rangeText } from "./row_text";
import { texts } from "./texts/texts";

interface TableProps {
  readonly board: Board;
  readonly now_ms: number;
}

type Departure = Board["departures"][number];
type Shuttle = Board["shuttles"][number];

/** The next trips of the timetable. What is expected is left out when the board is old. */
export function DepartureTable({
  board,
  now_ms,
  is_stale,
}: TableProps & { readonly is_stale: boolean }) {
  const t = texts.value;
  const rows = is_stale
    ? board.departures.filter((row) => Date.parse(row.leave_at) >= now_ms)
    : board.departures;
  return (
    <section aria-labelledby="timetable">
      <h2 id="timetable">{t.timetable}</h2>
      {rows.length === 0 ? (
        <p class="empty">{t.no_departures}</p>
      ) : (
        <table>
          <thead>
            <tr>
              <th scope="col">{t.leaves}</th>
              <th scope="col">{t.towards}</th>
              {!is_stale && <th scope="col">{t.expected}</th>}
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr key={`${row.trip_id} ${row.leave_at}`} data-trip={row.trip_id}>
                <td class="time">{formatTime(row.leave_at, language.value, board.timezone)}</td>
                <td>
                  {destination(row)}
                  {row.is_last && <small>{t.last}</small>}
                </td>
                {!is_stale && (
                  <td>
                    {departureText(row, board, now_ms)}
                    <Details row={row} />
                  </td>
                )}
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}

/** Shuttles that come for riders who booked. */
export function ShuttleTable({ board, now_ms }: TableProps) {
  const t = texts.value;
  return (
    <section aria-labelledby="shuttles">
      <h2 id="shuttles">{t.shuttles}</h2>
      {board.shuttles.length === 0 ? (
        <p class="empty">{t.no_shuttles}</p>
      ) : (
        <table>
          <thead>
            <tr>
              <th scope="col">{t.shuttle}</th>
              <th scope="col">{t.expected}</th>
            </tr>
          </thead>
          <tbody>
            {board.shuttles.map((row, number) => (
              <tr key={`${row.vehicle_name} ${number}`} data-shuttle={row.vehicle_name}>
                <td>{row.vehicle_name}</td>
                <td>
                  {shuttleText(row, board, now_ms)}
                  {row.seats_left != null && <small>{t.seats(row.seats_left)}</small>}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </section>
  );
}

function Details({ row }: { readonly row: Departure }) {
  const seats = row.seats_left == null ? "" : texts.value.seats(row.seats_left);
  const parts = [row.vehicle_name, seats].filter((part) => part !== "");
  return parts.length === 0 ? null : <small>{parts.join(" · ")}</small>;
}

function departureText(row: Departure, board: Board, now_ms: number): string {
  const t = texts.value;
  if (row.is_here) return t.here;
  if (row.state === "missed") return t.missed;
  if (row.expected !== null) return rangeText(row.expected, momentOf(board, now_ms), t);
  return row.vehicle_name === "" ? t.on_schedule : t.time_unknown;
}

function shuttleText(row: Shuttle, board: Board, now_ms: number): string {
  const t = texts.value;
  if (row.is_here) return t.here;
  return row.expected === null
    ? t.time_unknown
    : rangeText(row.expected, momentOf(board, now_ms), t);
}

function momentOf(board: Board, now_ms: number) {
  return { now_ms, language: language.value, timezone: board.timezone };
}

function destination(row: Departure): string {
  const [first, second] =
    language.value === "en" ? [row.to_name_en, row.to_name] : [row.to_name, row.to_name_en];
  return first || second || row.to_stop;
}
