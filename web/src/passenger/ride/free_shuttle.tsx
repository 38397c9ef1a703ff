import { serverNow_ms } from "../../shared/api/server_time";
import { batch, useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { formatTime, toLocalInput } from "../../shared/texts/times";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import {
  bookRide,
  destination,
  earliest,
  mayWalk,
  party,
  pickup,
  wheelchairs,
} from "../booking/ride_request";
import type { Campus } from "../campus/campus";
import { goTo } from "../navigation";
import { title_prefix } from "../page_title";
import { texts } from "../texts/texts";
import { storeRideToken } from "../token_storage";
import { pulse } from "./arrival_signs";
import type { Ticket } from "./ride_tracker";

/** Often enough that the passenger is among the first, and far below the server's limit. */
const LOOK_MS = 15_000;
/** After the server said that this network asks too often. */
const REST_MS = 60_000;

/** Rules that no waiting changes. */
const HOPELESS: ReadonlySet<string> = new Set(["no_service", "stop_unknown"]);

type Offer = Schemas["OfferView"];

interface FreeShuttleProps {
  readonly ticket: Ticket;
  readonly campus: Campus;
  /** A shuttle is free, so that its button is the one strong button of the page; or no longer. */
  readonly onFree: (is_free: boolean) => void;
}

export function canWait(ticket: Ticket, wheelchairs_max: number): boolean {
  return !HOPELESS.has(ticket.reason) && ticket.wheelchairs <= wheelchairs_max;
}

/** After a refusal: looks for a free shuttle while the page is open, and then books it by one tap. */
export function FreeShuttle({ ticket, campus, onFree }: FreeShuttleProps) {
  const is_waiting = useSignal(false);
  const offer = useSignal<Offer | null>(null);
  const problem = useSignal<Problem | null>(null);
  const is_booking = useSignal(false);
  const t = texts.value;
  const { timezone } = campus.view;
  const accept = (found: Offer | null, failed: Problem | null) => {
    const was_free = offer.peek()?.is_free === true;
    const is_free = found?.is_free === true;
    batch(() => {
      offer.value = found;
      problem.value = failed;
    });
    title_prefix.value = is_free ? texts.peek().short_free : "";
    onFree(is_free);
    if (is_free && !was_free) pulse();
  };
  useEffect(() => {
    if (!is_waiting.value) return undefined;
    let is_over = false;
    let timer = 0;
    const look = async () => {
      const result = await resultOf(api.POST("/api/v1/rides/offers", { body: requestOf(ticket) }));
      if (is_over) return;
      accept(result.ok ? result.value : null, result.ok ? null : result.problem);
      const rests = !result.ok && result.problem.status === 429;
      timer = window.setTimeout(() => void look(), rests ? REST_MS : LOOK_MS);
    };
    void look();
    return () => {
      is_over = true;
      clearTimeout(timer);
      title_prefix.value = "";
      onFree(false);
    };
  }, [is_waiting.value, ticket.ride_id]);
  const book = async () => {
    fillRequest(ticket, timezone);
    is_booking.value = true;
    const result = await bookRide(timezone);
    is_booking.value = false;
    if (!result.ok) {
      accept(null, result.problem);
      return;
    }
    if (result.value.state !== "refused") storeRideToken(result.value.token);
    goTo({ view: "ride", token: result.value.token });
  };
  const found = offer.value;
  if (!is_waiting.value)
    return (
      <button type="button" class="button wide" onClick={() => (is_waiting.value = true)}>
        {t.tell_when_free}
      </button>
    );
  return (
    <section class="free-shuttle" aria-live="polite" data-free={found?.is_free || undefined}>
      {found?.is_free === true ? (
        <>
          <Alert tone="good">{t.is_free}</Alert>
          <button
            type="button"
            class="button main large wide"
            disabled={is_booking.value}
            onClick={() => void book()}
          >
            {is_booking.value
              ? t.booking
              : t.book_free(formatTime(found.pickup_at ?? "", language.value, timezone))}
          </button>
        </>
      ) : (
        <>
          {problem.value === null ? (
            <Alert>{t.waiting_for_free}</Alert>
          ) : (
            <ProblemAlert problem={problem.value} />
          )}
          <button type="button" class="button wide" onClick={() => (is_waiting.value = false)}>
            {t.stop_waiting}
          </button>
        </>
      )}
    </section>
  );
}

/** The refused request again; its time is now if it is over. */
function requestOf(ticket: Ticket): Schemas["RideRequest"] {
  const is_ahead = Date.parse(ticket.earliest) > serverNow_ms();
  return {
    from_stop: ticket.from_stop,
    to_stop: ticket.to_stop,
    party: ticket.party,
    wheelchairs: ticket.wheelchairs,
    earliest: is_ahead ? ticket.earliest : null,
    may_walk: false,
  };
}

function fillRequest(ticket: Ticket, timezone: string): void {
  const earliest_ms = Date.parse(ticket.earliest);
  batch(() => {
    pickup.value = ticket.from_stop;
    destination.value = ticket.to_stop;
    party.value = ticket.party;
    wheelchairs.value = ticket.wheelchairs;
    earliest.value = earliest_ms > serverNow_ms() ? toLocalInput(earliest_ms, timezone) : "";
    mayWalk.value = false;
  });
}
