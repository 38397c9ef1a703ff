import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Loading, ProblemAlert } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { link, may } from "../session";
import { vehicleName } from "../texts/names";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTimeOrDateTime } from "../texts/times";
import { CancelRideButton } from "./cancel_ride_button";
import { EraseRideButton } from "./erase_ride_button";
import { RideDecisions } from "./ride_decisions";
import { RideDelays } from "./ride_delays";
import { RideHistory } from "./ride_history";

type Ride = Schemas["RideRecord"];

interface RideStory {
  readonly ride: Ride;
  readonly history: readonly Schemas["RideEventView"][];
  readonly decisions: readonly Schemas["DecisionView"][];
}

/** Everything about one ride: times promised and actual, why this shuttle, whom it delays, what happened. */
export function RidePage({ ride_id }: { readonly ride_id: string }) {
  const t = texts.value;
  const story = useSignal<RideStory | null>(null);
  const problem = useSignal<Problem | null>(null);
  // The scene says that something about the rides changed; what, the API says.
  const changes = link.value?.scene.value?.rides;
  useEffect(() => {
    let is_wanted = true;
    const params = { params: { path: { ride_id } } };
    void Promise.all([
      resultOf(api.GET("/api/v1/rides/id/{ride_id}", params)),
      resultOf(api.GET("/api/v1/rides/id/{ride_id}/history", params)),
      resultOf(api.GET("/api/v1/rides/id/{ride_id}/decisions", params)),
    ]).then(([ride, history, decisions]) => {
      if (!is_wanted) return;
      const failed = [ride, history, decisions].find((result) => !result.ok);
      problem.value = failed === undefined || failed.ok ? null : failed.problem;
      if (ride.ok && history.ok && decisions.ok)
        story.value = { ride: ride.value, history: history.value, decisions: decisions.value };
    });
    return () => {
      is_wanted = false;
    };
  }, [ride_id, changes]);
  const shown = story.value;
  return (
    <section class="sheet narrow">
      <p>
        <a href={fragmentOf("rides")}>{t.all_rides}</a>
      </p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {shown === null ? (
        problem.value === null && <Loading text={t.loading} />
      ) : (
        <Story {...shown} />
      )}
    </section>
  );
}

function Story({ ride, history, decisions }: RideStory) {
  const t = texts.value;
  const waits = ride.state === "assigned" || ride.state === "boarding";
  return (
    <>
      <header class="sheet-head">
        <h1>{t.ride_title(ride.ride_code === "" ? t.rider_erased : ride.ride_code)}</h1>
        <div class="buttons">
          <CancelRideButton ride={ride} />
          <EraseRideButton ride={ride} />
        </div>
      </header>
      <dl class="facts">
        <Fact name={t.state} value={t.states[ride.state]} more={t.reasons[ride.reason]} />
        <Fact
          name={t.trip}
          value={`${stopName(ride.from_stop)} – ${stopName(ride.to_stop)}`}
          more={ride.first_to_stop === null ? undefined : t.booked_to(stopName(ride.first_to_stop))}
        />
        <Fact
          name={t.people}
          value={String(ride.party)}
          more={ride.wheelchairs > 0 ? t.wheelchairs_of(ride.wheelchairs) : undefined}
        />
        <Fact
          name={t.vehicle}
          value={ride.vehicle_id === null ? t.none : vehicleName(ride.vehicle_id)}
        />
        <Fact
          name={t.requested}
          value={formatTimeOrDateTime(ride.requested_at)}
          more={t.sources[ride.source]}
        />
        <Fact name={t.boarding_code} value={ride.boarding_code || t.none} />
      </dl>
      <PromisedAndActual ride={ride} />
      {ride.feedback != null && (
        <p data-feedback>
          {ride.feedback.rating !== null && t.rated(ride.feedback.rating)}{" "}
          {ride.feedback.lost_property !== "" && t.lost_property(ride.feedback.lost_property)}
        </p>
      )}
      <RideDecisions decisions={decisions} />
      {waits && may("dispatcher", "safety") && <RideDelays ride_id={ride.ride_id} />}
      <RideHistory history={history} />
    </>
  );
}

interface FactProps {
  readonly name: string;
  readonly value: string;
  readonly more?: string | undefined;
}

function Fact({ name, value, more }: FactProps) {
  return (
    <div>
      <dt>{name}</dt>
      <dd>
        {value}
        {more !== undefined && more !== "" && <small> {more}</small>}
      </dd>
    </div>
  );
}

function PromisedAndActual({ ride }: { readonly ride: Ride }) {
  const t = texts.value;
  const { promise, first_promise } = ride;
  const time = (at: string | null) => (at === null ? "–" : formatTimeOrDateTime(at));
  const range = (from: string, to: string) => `${time(from)}–${time(to)}`;
  return (
    <div class="scroller">
      <table class="table">
        <thead>
          <tr>
            <th scope="col">
              <span class="visually-hidden">{t.times}</span>
            </th>
            {first_promise !== null && first_promise !== undefined && (
              <th scope="col">{t.first_promised}</th>
            )}
            <th scope="col">{t.promised}</th>
            <th scope="col">{t.expected_now}</th>
            <th scope="col">{t.actual}</th>
          </tr>
        </thead>
        <tbody>
          <tr>
            <th scope="row">{t.pickup}</th>
            {first_promise !== null && first_promise !== undefined && (
              <td>{range(first_promise.pickup_from, first_promise.pickup_to)}</td>
            )}
            <td>{promise === null ? "–" : range(promise.pickup_from, promise.pickup_to)}</td>
            <td>{time(ride.pickup_eta)}</td>
            <td data-actual="pickup">{time(ride.boarded_at)}</td>
          </tr>
          <tr>
            <th scope="row">{t.arrival}</th>
            {first_promise !== null && first_promise !== undefined && (
              <td>{t.by(time(first_promise.arrive_by))}</td>
            )}
            <td>{promise === null ? "–" : t.by(time(promise.arrive_by))}</td>
            <td>{time(ride.arrival_eta)}</td>
            <td data-actual="arrival">{ride.state === "completed" ? time(ride.ended_at) : "–"}</td>
          </tr>
        </tbody>
      </table>
    </div>
  );
}
