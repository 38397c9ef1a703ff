import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Problem } from "../../shared/api/problem";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import type { RideTracker, Ticket } from "./ride_tracker";

const RATINGS = [1, 2, 3, 4, 5] as const;

interface FeedbackFormProps {
  readonly ride: RideTracker;
  readonly ticket: Ticket;
}

/** After a ride: how it was, and what was left in the shuttle. It can be sent again, in place of the first. */
export function FeedbackForm({ ride, ticket }: FeedbackFormProps) {
  const told = ticket.feedback ?? null;
  const rating = useSignal<number | null>(told?.rating ?? null);
  const lost = useSignal(told?.lost_property ?? "");
  const busy = useSignal(false);
  const sent = useSignal(told !== null);
  const problem = useSignal<Problem | null>(null);
  const id = useId();
  const t = texts.value;
  const send = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    problem.value = await ride.giveFeedback(rating.value, lost.value.trim());
    busy.value = false;
    sent.value = problem.value === null;
  };
  const is_empty = rating.value === null && lost.value.trim() === "";
  return (
    <form class="feedback card" onSubmit={(event) => void send(event)}>
      <fieldset class="rating">
        <legend>{t.rate_ride}</legend>
        {RATINGS.map((stars) => (
          <label key={stars} title={t.ratings[stars]}>
            <input
              type="radio"
              name={`${id}-rating`}
              class="visually-hidden"
              checked={rating.value === stars}
              onChange={() => {
                rating.value = stars;
                sent.value = false;
              }}
            />
            <span aria-hidden="true">{(rating.value ?? 0) >= stars ? "★" : "☆"}</span>
            <span class="visually-hidden">{t.ratings[stars]}</span>
          </label>
        ))}
      </fieldset>
      <div class="field">
        <label for={id}>{t.lost_property}</label>
        <textarea
          id={id}
          class="input"
          maxLength={500}
          value={lost.value}
          aria-describedby={`${id}-hint`}
          onInput={(event) => {
            lost.value = event.currentTarget.value;
            sent.value = false;
          }}
        />
        <p class="hint" id={`${id}-hint`}>
          {t.lost_property_hint}
        </p>
      </div>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {sent.value ? (
        <Alert tone="good">{t.feedback_sent}</Alert>
      ) : (
        <button class="button wide" disabled={is_empty || busy.value}>
          {t.send_feedback}
        </button>
      )}
    </form>
  );
}
