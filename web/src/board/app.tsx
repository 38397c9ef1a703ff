import { useSignalEffect } from "@preact/signals";
import { language } from "../shared/texts/language";
import { formatTime, formatTimeOrDateTime, formatTimeWithSeconds } from "../shared/texts/times";
import { Alert, Loading } from "../shared/ui/alerts";
import type { Board, BoardTracker } from "./board_tracker";
import { DepartureTable, ShuttleTable } from "./tables";
import { texts } from "./texts/texts";

const CLOSING_SOON_MS = 60 * 60_000;

/** A screen at a stop, read from some metres away: what leaves next, and how to book from here. */
export function App({ tracker }: { readonly tracker: BoardTracker }) {
  const [board, t] = [tracker.board.value, texts.value];
  useSignalEffect(() => {
    const shown = tracker.board.value;
    if (shown !== null) document.title = texts.value.title(nameOf(shown));
  });
  if (tracker.is_unknown.value)
    return (
      <main class="board">
        <h1>{t.unknown_stop(tracker.stop_id)}</h1>
      </main>
    );
  if (board === null)
    return (
      <main class="board">
        <Loading text={t.loading} />
      </main>
    );
  const is_stale = tracker.is_stale.value;
  const timezone = board.timezone;
  return (
    <main class="board" data-stale={is_stale}>
      <header>
        <h1>
          {nameOf(board)}
          <small lang={language.value === "en" ? "zh-CN" : "en"}>{otherNameOf(board)}</small>
        </h1>
        <p class="clock">{formatTime(tracker.now_ms.value, language.value, timezone)}</p>
      </header>
      <Notices board={board} now_ms={tracker.now_ms.value} />
      {is_stale && (
        <Alert tone="danger">{t.offline(formatTime(board.now, language.value, timezone))}</Alert>
      )}
      <div class="columns">
        <div>
          <DepartureTable board={board} now_ms={tracker.now_ms.value} is_stale={is_stale} />
          {!is_stale && <ShuttleTable board={board} now_ms={tracker.now_ms.value} />}
        </div>
        <aside>
          <h2>{t.book}</h2>
          <img class="code" src={codeOf(board)} alt={board.book_url} />
          <p>{t.book_hint}</p>
        </aside>
      </div>
      <p class="as-of">{t.as_of(formatTimeWithSeconds(board.now, language.value, timezone))}</p>
    </main>
  );
}

interface NoticesProps {
  readonly board: Board;
  readonly now_ms: number;
}

function Notices({ board, now_ms }: NoticesProps) {
  const t = texts.value;
  const time = (moment: string) =>
    formatTimeOrDateTime(moment, board.now, language.value, board.timezone);
  const { open_now, opens_next, closes_at, holiday, closures, announcements } = board;
  // Without a connection the list stays as it was.
  const stands = ({ ends_at }: Board["announcements"][number]) =>
    ends_at === null || Date.parse(ends_at) > now_ms;
  const closes_soon =
    closes_at !== null && Date.parse(closes_at) - Date.parse(board.now) < CLOSING_SOON_MS;
  return (
    <>
      {announcements.filter(stands).map((one) => (
        <div key={one.announcement_id} data-announcement>
          <Alert>
            <strong>{language.value === "en" ? one.text_en : one.text_zh}</strong>
            <small lang={language.value === "en" ? "zh-CN" : "en"}>
              {language.value === "en" ? one.text_zh : one.text_en}
            </small>
          </Alert>
        </div>
      ))}
      {holiday !== null && <Alert>{t.holiday(holiday)}</Alert>}
      {closures.map((one) => (
        <div key={`${one.starts_at} ${one.reason}`} data-closure>
          <Alert tone={one.is_served ? "warning" : "danger"}>
            {[
              one.is_served ? t.road_closed : t.stop_closed,
              Date.parse(one.starts_at) > Date.parse(board.now) && t.from(time(one.starts_at)),
              one.ends_at === null ? t.until_further_notice : t.until(time(one.ends_at)),
              one.reason,
            ]
              .filter((part) => typeof part === "string" && part !== "")
              .join(" · ")}
          </Alert>
        </div>
      ))}
      {!open_now && (
        <Alert tone="warning">
          {opens_next === null ? t.closed : t.closed_until(time(opens_next))}
        </Alert>
      )}
      {open_now && closes_soon && <Alert tone="warning">{t.closes_soon(time(closes_at))}</Alert>}
    </>
  );
}

function codeOf(board: Board): string {
  return `/api/v1/stops/${encodeURIComponent(board.stop.stop_id)}/board/code`;
}

function nameOf({ stop }: Board): string {
  return language.value === "en" ? stop.name_en || stop.name : stop.name || stop.name_en;
}

/** In the other language, for those who do not read this one. */
function otherNameOf(board: Board): string {
  const { name, name_en } = board.stop;
  const other = language.value === "en" ? name : name_en;
  return other === nameOf(board) ? "" : other;
}
