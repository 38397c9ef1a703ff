import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { hasEnded } from "../../shared/scene/scene";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import { goTo } from "../navigation";
import { openRidesOnly, rides } from "../store/lists";
import { stopTitle } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { near } from "../texts/times";
import { lateMinutes } from "./promises";

type Ride = Schemas["RideRecord"];

export function RidesPage() {
  const t = texts.value;
  const shown = rides.value.value;
  useEffect(() => void rides.refresh(), []);
  const filter = (open_only: boolean) => {
    openRidesOnly.value = open_only;
    rides.forget();
    void rides.refresh();
  };
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.rides}</h1>
        <div class="switch">
          <button type="button" aria-pressed={openRidesOnly.value} onClick={() => filter(true)}>
            {t.rides_open}
          </button>
          <button type="button" aria-pressed={!openRidesOnly.value} onClick={() => filter(false)}>
            {t.rides_all}
          </button>
        </div>
      </header>
      {rides.problem.value !== null && <ProblemNote problem={rides.problem.value} />}
      {shown === null && rides.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <Note>{t.no_rides}</Note>}
      {shown !== null && shown.length > 0 && <RidesTable shown={shown} />}
    </section>
  );
}

function RidesTable({ shown }: { readonly shown: readonly Ride[] }) {
  const t = texts.value;
  const columns = [t.ride_code, t.state, t.trip, t.people, t.vehicle, t.pickup, t.arrival];
  return (
    <div class="scroller">
      <table class="table">
        <thead>
          <tr>
            {columns.map((title) => (
              <th key={title} scope="col">
                {title}
              </th>
            ))}
            <th scope="col">
              <span class="unseen">{t.cancel_ride}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {shown.map((ride) => (
            <RideRow key={ride.ride_id} ride={ride} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function RideRow({ ride }: { readonly ride: Ride }) {
  const t = texts.value;
  const { promise } = ride;
  return (
    <tr data-ride={ride.ride_code}>
      <th scope="row" class="mono">
        {ride.ride_code}
      </th>
      <td data-label={t.state}>
        <span class={`chip ${toneOf(ride)}`}>{t.states[ride.state]}</span>
        {ride.reason !== "" && (
          <small title={ride.reason_detail}>{t.reasons[ride.reason] ?? ride.reason}</small>
        )}
      </td>
      <td data-label={t.trip}>
        {stopTitle(ride.from_stop)} – {stopTitle(ride.to_stop)}
        {ride.first_to_stop !== null && <small>{t.booked_to(stopTitle(ride.first_to_stop))}</small>}
        {ride.let_out && !hasEnded(ride.state) && <small>{t.let_out_asked}</small>}
      </td>
      <td data-label={t.people}>{ride.party}</td>
      <td data-label={t.vehicle}>
        {ride.vehicle_id !== null && (
          <button type="button" class="plain-link" onClick={() => goTo("live", ride.vehicle_id!)}>
            {ride.vehicle_id}
          </button>
        )}
      </td>
      <td data-label={t.pickup}>
        {promise !== null && (
          <Moments
            promised={`${near(promise.pickup_from)}–${near(promise.pickup_to)}`}
            expected={ride.boarded_at ?? ride.pickup_eta}
            latest={promise.pickup_to}
          />
        )}
      </td>
      <td data-label={t.arrival}>
        {promise !== null && (
          <Moments
            promised={t.by(near(promise.arrive_by))}
            expected={ride.state === "completed" ? ride.ended_at : ride.arrival_eta}
            latest={promise.arrive_by}
          />
        )}
      </td>
      <td>
        <CancelRide ride={ride} />
      </td>
    </tr>
  );
}

function toneOf(ride: Ride): string {
  if (ride.state === "failed" || ride.promise_broken) return "danger";
  if (ride.state === "refused" || ride.state === "no_show") return "warning";
  return ride.state === "aboard" || ride.state === "boarding" ? "good" : "calm";
}

interface MomentsProps {
  readonly promised: string;
  readonly expected: string | null;
  readonly latest: string;
}

/** The promise, and what is expected now, with the difference where it breaks the promise. */
function Moments({ promised, expected, latest }: MomentsProps) {
  const t = texts.value;
  const late = lateMinutes(expected, latest);
  return (
    <>
      <span>{promised}</span>
      {expected !== null && (
        <small>
          {t.expected} {near(expected)}
        </small>
      )}
      {late > 0 && <span class="chip danger">{t.late(late)}</span>}
    </>
  );
}

function CancelRide({ ride }: { readonly ride: Ride }) {
  const asking = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const is_aboard = ride.state === "aboard";
  if (hasEnded(ride.state) || ride.let_out) return null;
  const cancel = async () => {
    asking.value = false;
    const path = { params: { path: { ride_id: ride.ride_id } } };
    const answer = await answerOf(api.POST("/api/v1/rides/id/{ride_id}/cancel", path));
    problem.value = answer.ok ? null : answer.problem;
    await rides.refresh();
  };
  return (
    <>
      <button
        type="button"
        class="button small"
        onClick={() => {
          asking.value = true;
        }}
      >
        {is_aboard ? t.let_out : t.cancel_ride}
      </button>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {asking.value && (
        <Question
          danger
          title={is_aboard ? t.let_out_title(ride.ride_code) : t.cancel_ride_title(ride.ride_code)}
          text={is_aboard ? t.let_out_text : t.cancel_ride_text}
          yes={is_aboard ? t.let_out : t.cancel_ride_yes}
          no={t.cancel}
          onNo={() => {
            asking.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </>
  );
}
