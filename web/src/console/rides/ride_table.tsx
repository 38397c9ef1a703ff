import type { Schemas } from "../../shared/api/client";
import { hasEnded } from "../../shared/scene/scene";
import { fragmentOf } from "../address";
import { goTo } from "../navigation";
import { stopName } from "../texts/stop_names";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTimeOrDateTime } from "../texts/times";
import { CancelRideButton } from "./cancel_ride_button";
import { EraseRideButton } from "./erase_ride_button";
import { lateMinutes } from "./promises";

type Ride = Schemas["RideRecord"];

export function RideTable({ shown }: { readonly shown: readonly Ride[] }) {
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
              <span class="visually-hidden">{t.cancel_ride}</span>
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
    <tr data-ride={ride.ride_code} data-ride-id={ride.ride_id}>
      <th scope="row" class="mono">
        <a href={fragmentOf("rides", ride.ride_id)}>
          {ride.ride_code === "" ? t.rider_erased : ride.ride_code}
        </a>
      </th>
      <td data-label={t.state}>
        <span class={`chip ${toneOf(ride)}`}>{t.states[ride.state]}</span>
        {ride.feedback != null && <Feedback told={ride.feedback} />}
        {t.reasons[ride.reason] !== undefined && <small>{t.reasons[ride.reason]}</small>}
      </td>
      <td data-label={t.trip}>
        {stopName(ride.from_stop)} – {stopName(ride.to_stop)}
        {ride.first_to_stop !== null && <small>{t.booked_to(stopName(ride.first_to_stop))}</small>}
        {ride.let_out && !hasEnded(ride.state) && <small>{t.let_out_asked}</small>}
      </td>
      <td data-label={t.people}>{ride.party}</td>
      <td data-label={t.vehicle}>
        {ride.vehicle_id !== null && (
          <button type="button" class="plain-link" onClick={() => goTo("live", ride.vehicle_id!)}>
            {vehicleName(ride.vehicle_id)}
          </button>
        )}
      </td>
      <td data-label={t.pickup}>
        {promise !== null && (
          <PromisedTime
            promised={`${formatTimeOrDateTime(promise.pickup_from)}–${formatTimeOrDateTime(promise.pickup_to)}`}
            expected={ride.boarded_at ?? ride.pickup_eta}
            latest={promise.pickup_to}
          />
        )}
      </td>
      <td data-label={t.arrival}>
        {promise !== null && (
          <PromisedTime
            promised={t.by(formatTimeOrDateTime(promise.arrive_by))}
            expected={ride.state === "completed" ? ride.ended_at : ride.arrival_eta}
            latest={promise.arrive_by}
          />
        )}
      </td>
      <td>
        <CancelRideButton ride={ride} />
        <EraseRideButton ride={ride} />
      </td>
    </tr>
  );
}

/** What the passenger said after the ride. */
function Feedback({ told }: { readonly told: NonNullable<Ride["feedback"]> }) {
  const t = texts.value;
  return (
    <small data-feedback>
      {told.rating !== null && t.rated(told.rating)}
      {told.lost_property !== "" && <span class="lost">{t.lost_property(told.lost_property)}</span>}
    </small>
  );
}

function toneOf(ride: Ride): string {
  if (ride.state === "failed" || ride.promise_broken) return "danger";
  if (ride.state === "refused" || ride.state === "no_show") return "warning";
  return ride.state === "aboard" || ride.state === "boarding" ? "good" : "calm";
}

interface PromisedTimeProps {
  readonly promised: string;
  readonly expected: string | null;
  readonly latest: string;
}

/** The promised time, the expected one, and the delay if it breaks the promise. */
function PromisedTime({ promised, expected, latest }: PromisedTimeProps) {
  const t = texts.value;
  const late = lateMinutes(expected, latest);
  return (
    <>
      <span>{promised}</span>
      {expected !== null && (
        <small>
          {t.expected} {formatTimeOrDateTime(expected)}
        </small>
      )}
      {late > 0 && <span class="chip danger">{t.late(late)}</span>}
    </>
  );
}
