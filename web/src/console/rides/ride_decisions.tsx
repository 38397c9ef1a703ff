import type { Schemas } from "../../shared/api/client";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTime, formatTimeOrDateTime } from "../texts/times";

type Decision = Schemas["DecisionView"];
type Quote = Schemas["QuoteView"];

/** Why this shuttle, and which one came next; or the rule by which the ride was refused. */
export function RideDecisions({ decisions }: { readonly decisions: readonly Decision[] }) {
  const t = texts.value;
  return (
    <section>
      <h2>{t.why_this_shuttle}</h2>
      {decisions.length === 0 && <p class="empty">{t.no_decisions}</p>}
      <ol class="decisions">
        {decisions.map((decision) => (
          <li key={decision.made_at}>
            <time>{formatTimeOrDateTime(decision.made_at)}</time>
            <DecisionText decision={decision} />
          </li>
        ))}
      </ol>
    </section>
  );
}

function DecisionText({ decision }: { readonly decision: Decision }) {
  const t = texts.value;
  const { best, runner_up, rule, vehicles } = decision;
  if (best === null)
    return (
      <p>
        {t.refused_by(t.reasons[rule] ?? rule)} {t.asked(vehicles)}
      </p>
    );
  return (
    <>
      <p>
        {t.got_it(vehicleName(best.vehicle_id), ...timesOf(best))} {t.asked(vehicles)}
      </p>
      <p data-runner-up>
        {runner_up === null
          ? t.no_runner_up
          : t.runner_up(
              vehicleName(runner_up.vehicle_id),
              ...timesOf(runner_up),
              Math.round(runner_up.extra_cost_s - best.extra_cost_s),
            )}
      </p>
    </>
  );
}

function timesOf(quote: Quote): [pickup: string, arrival: string] {
  return [formatTime(quote.pickup_at), formatTime(quote.arrival_at)];
}
