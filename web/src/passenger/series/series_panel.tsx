import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Answer, Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { calendarDay, clockTime, weekdayName } from "../../shared/texts/times";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import { DestinationMark, PickupMark } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { forgetSeries } from "../token_storage";

type Ticket = Schemas["SeriesTicket"];
type Day = Schemas["DayView"];

const REFRESH_MS = 20_000;
const SHOWN_AT_FIRST = 7;

interface SeriesPanelProps {
  readonly token: string;
  readonly campus: Campus;
}

/** One recurring booking: what it is, and what has become of each of its days. */
export function SeriesPanel({ token, campus }: SeriesPanelProps) {
  const ticket = useSignal<Ticket | null>(null);
  const problem = useSignal<Problem | null>(null);
  const take = (answer: Answer<Ticket>) => {
    if (answer.ok) {
      ticket.value = answer.value;
      if (answer.value.state !== "active") forgetSeries(token);
    }
    problem.value = answer.ok ? null : answer.problem;
  };
  useEffect(() => {
    const load = async () => {
      const path = { token };
      take(await answerOf(api.GET("/api/v1/series/{token}", { params: { path } })));
    };
    void load();
    const timer = window.setInterval(() => void load(), REFRESH_MS);
    return () => window.clearInterval(timer);
  }, [token]);
  const shown = ticket.value;
  return (
    <section class="ride">
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {shown === null ? (
        problem.value === null && <Loading text={texts.value.series_loading} />
      ) : (
        <Shown ticket={shown} campus={campus} onAnswer={take} />
      )}
      <button type="button" class="button" onClick={() => goTo({ view: "book" })}>
        {texts.value.book_another}
      </button>
    </section>
  );
}

interface ShownProps {
  readonly ticket: Ticket;
  readonly campus: Campus;
  readonly onAnswer: (answer: Answer<Ticket>) => void;
}

function Shown({ ticket, campus, onAnswer }: ShownProps) {
  const t = texts.value;
  const all = useSignal(false);
  const today = calendarDay(new Date(campus.view.now).getTime(), ticket.timezone);
  const coming = ticket.days.filter((day) => day.day >= today);
  const listed = all.value ? coming : coming.slice(0, SHOWN_AT_FIRST);
  const name = (stop_id: string) => nameOfStop(campus.shape.stops, stop_id, language.value);
  return (
    <>
      <h1>{t.series_title}</h1>
      {ticket.state !== "active" && <Note>{t.series_states[ticket.state]}</Note>}
      <article class={`ticket card ${ticket.state === "active" ? "" : "ended"}`}>
        <dl class="trip">
          <div>
            <dt>
              <PickupMark />
              <span class="unseen">{t.from}</span>
            </dt>
            <dd>
              {name(ticket.from_stop)}
              <small>
                {weekdaysText(ticket.weekdays)} · {ticket.leave}
              </small>
            </dd>
          </div>
          <div>
            <dt>
              <DestinationMark />
              <span class="unseen">{t.to}</span>
            </dt>
            <dd>
              {name(ticket.to_stop)}
              <small>{t.series_until(dateText(ticket.ends_on))}</small>
            </dd>
          </div>
        </dl>
        <p class="stub">
          <span>{t.party(ticket.party)}</span>
          {ticket.wheelchairs > 0 && <span>{t.party_wheelchairs(ticket.wheelchairs)}</span>}
        </p>
      </article>
      <h2>{t.series_days}</h2>
      {coming.length === 0 && <p class="empty">{t.series_no_days}</p>}
      <ul class="days">
        {listed.map((day) => (
          <li key={day.day} data-day={day.day} data-state={day.state}>
            <DayLine ticket={ticket} day={day} onAnswer={onAnswer} />
          </li>
        ))}
      </ul>
      {listed.length < coming.length && (
        <button
          type="button"
          class="button quiet small"
          onClick={() => {
            all.value = true;
          }}
        >
          {t.series_all_days(coming.length)}
        </button>
      )}
      {ticket.state === "active" && <CancelAll ticket={ticket} onAnswer={onAnswer} />}
    </>
  );
}

function DayLine({ ticket, day, onAnswer }: Omit<ShownProps, "campus"> & { readonly day: Day }) {
  const t = texts.value;
  const { ride } = day;
  const cancel = async () => {
    const path = { token: ticket.token, day: day.day };
    onAnswer(
      await answerOf(api.POST("/api/v1/series/{token}/days/{day}/cancel", { params: { path } })),
    );
  };
  const may_cancel =
    ticket.state === "active" &&
    (day.state === "planned" ||
      day.state === "trying" ||
      (day.state === "booked" &&
        (ride === null || (isWaiting(ride.state) && ride.state !== "aboard"))));
  return (
    <>
      <div>
        <strong>{dateText(day.day)}</strong>
        <span class={`day-state ${day.state}`}>{dayStateText(ticket, day)}</span>
      </div>
      <div class="day-buttons">
        {ride !== null && isWaiting(ride.state) && (
          <button
            type="button"
            class="button small"
            onClick={() => goTo({ view: "ride", token: ride.token })}
          >
            {t.show_ride}
          </button>
        )}
        {may_cancel && (
          <button type="button" class="button small" onClick={() => void cancel()}>
            {t.series_cancel_day}
          </button>
        )}
      </div>
    </>
  );
}

function dayStateText(ticket: Ticket, day: Day): string {
  const t = texts.value;
  const { ride } = day;
  const reason = t.reasons[day.reason] ?? day.reason_detail;
  switch (day.state) {
    case "booked":
      if (ride === null || ride.promise === null) return t.series_booked;
      if (!isWaiting(ride.state)) return t.series_ride_states[ride.state] ?? t.series_booked;
      return t.pickup_window(
        time(ride.promise.pickup_from, ticket),
        time(ride.promise.pickup_to, ticket),
      );
    case "planned":
      return t.series_planned;
    case "trying":
      return t.series_trying(reason);
    case "refused":
      return t.series_refused(reason);
    case "skipped":
      return t.series_skipped(day.reason_detail);
    case "cancelled":
      return t.series_day_cancelled;
  }
}

function CancelAll({ ticket, onAnswer }: Omit<ShownProps, "campus">) {
  const asking = useSignal(false);
  const t = texts.value;
  const cancel = async () => {
    asking.value = false;
    const path = { token: ticket.token };
    onAnswer(await answerOf(api.POST("/api/v1/series/{token}/cancel", { params: { path } })));
  };
  return (
    <>
      <button
        type="button"
        class="button danger"
        onClick={() => {
          asking.value = true;
        }}
      >
        {t.series_cancel}
      </button>
      {asking.value && (
        <Question
          danger
          title={t.series_cancel_title}
          text={t.series_cancel_text}
          yes={t.series_cancel}
          no={t.cancel_no}
          onNo={() => {
            asking.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </>
  );
}

function isWaiting(state: string): boolean {
  return ["requested", "assigned", "boarding", "aboard"].includes(state);
}

function time(moment: string, ticket: Ticket): string {
  return clockTime(moment, language.value, ticket.timezone);
}

/** A date has no hour: noon in UTC lies on the same day wherever it is written out as UTC. */
function dateText(day: string): string {
  return new Intl.DateTimeFormat(language.value === "en" ? "en-GB" : language.value, {
    weekday: "short",
    day: "numeric",
    month: "short",
    timeZone: "UTC",
  }).format(new Date(`${day}T12:00:00Z`));
}

function weekdaysText(weekdays: readonly number[]): string {
  return weekdays.map((day) => weekdayName(day, language.value, "short")).join(" ");
}
