import { stopName } from "../../texts/stop_names";
import { texts } from "../../texts/texts";
import { formatTime, formatTimeWithSeconds } from "../../texts/times";
import { changedRides, figuresOfThen, type ForkedRide, type ForkView } from "./fork_rows";

const RIDES_SHOWN = 20;

interface ForkComparisonProps {
  readonly at_ms: number;
  readonly fork: ForkView;
}

/** As it was, dispatched again, and with the change; then the rides that the change treats differently. */
export function ForkComparison({ at_ms, fork }: ForkComparisonProps) {
  const t = texts.value;
  const { present, changed, rides, placed } = fork;
  const then = figuresOfThen(rides);
  const rows: readonly (readonly [string, string, string, string])[] = [
    [t.shuttles, "", String(present.shuttles), String(changed.shuttles)],
    [t.fork_served, String(then.served), String(present.served), String(changed.served)],
    [t.fork_refused, "", String(present.refused), String(changed.refused)],
    [
      t.fork_wait_median,
      minutes(then.wait_median_s),
      minutes(present.wait_median_s),
      minutes(changed.wait_median_s),
    ],
    [
      t.fork_wait_p95,
      minutes(then.wait_p95_s),
      minutes(present.wait_p95_s),
      minutes(changed.wait_p95_s),
    ],
    [t.fork_on_board, "", minutes(present.ride_mean_s), minutes(changed.ride_mean_s)],
    [t.fork_driving, "", present.driving_h.toFixed(1), changed.driving_h.toFixed(1)],
  ];
  const different = changedRides(rides);
  return (
    <>
      <p class="hint">
        {t.fork_of(formatTimeWithSeconds(at_ms), rides.length, placed)} {t.fork_as_planned}{" "}
        {t.fork_cost(fork.computing_s.toFixed(1))}
      </p>
      <div class="scroller">
        <table class="table compact">
          <thead>
            <tr>
              <td />
              {[t.fork_then, t.fork_again, t.fork_changed].map((title) => (
                <th key={title} scope="col">
                  {title}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map(([name, ...values]) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                {values.map((value, k) => (
                  <td key={k}>{value === "" ? "–" : value}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <h3>{t.fork_different(different.length)}</h3>
      <ul class="plain fork-rides">
        {different.slice(0, RIDES_SHOWN).map((ride) => (
          <RideRow key={ride.ride_id} ride={ride} />
        ))}
      </ul>
      {different.length > RIDES_SHOWN && <p class="hint">{t.fork_only_first(RIDES_SHOWN)}</p>}
    </>
  );
}

function RideRow({ ride }: { readonly ride: ForkedRide }) {
  const t = texts.value;
  const end = (state: ForkedRide["present_end"], wait_s: number | null) =>
    state === "served" ? t.fork_waits(minutes(wait_s)) : t.fork_ends[state];
  return (
    <li>
      <strong>{ride.ride_code}</strong> {formatTime(ride.requested_at)} · {stopName(ride.from_stop)}{" "}
      → {stopName(ride.to_stop)}
      <br />
      <span class="hint">
        {end(ride.present_end, ride.present_wait_s)} →{" "}
        <strong>{end(ride.changed_end, ride.changed_wait_s)}</strong>
      </span>
    </li>
  );
}

function minutes(seconds: number | null): string {
  return seconds === null ? "" : texts.value.fork_minutes((seconds / 60).toFixed(1));
}
