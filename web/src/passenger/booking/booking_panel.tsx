import { signal, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { DestinationIcon, PickupIcon, SwapIcon } from "../../shared/ui/icons";
import { Stepper } from "../../shared/ui/stepper";
import { laterViews } from "../later/later_views";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { storeRideToken, storeSeriesToken } from "../token_storage";
import { CurrentRideAlert, CurrentSeriesButton } from "./current_bookings";
import { PickupTimeField, isPickupTimeValid } from "./pickup_time_field";
import type { RideEnd } from "./ride_request";
import {
  bookRide,
  canBook,
  chooseStop,
  currentTrip,
  destination,
  fillTrip,
  mayWalk,
  party,
  pickup,
  setParty,
  swapEnds,
  wheelchairs,
} from "./ride_request";
import { bookSeries, isRecurring, isSeriesRequestValid } from "./series_request";
import { LastTripList } from "./last_trip_list";
import type { LastTrip } from "./last_trips";
import { rememberTrip } from "./last_trips";
import { fillFromLink } from "./link_request";
import { QuickStops } from "./quick_stops";
import { ServiceAlert } from "./service_alert";
import { StopPicker } from "./stop_picker";

export function BookingPanel({ campus }: { readonly campus: Campus }) {
  const open_picker = useSignal<RideEnd | null>(null);
  // Where the focus goes when the list of stops has closed: it would fall to the page's beginning.
  const next_focus = useSignal<RideEnd | null>(null);
  useEffect(() => readLink(campus), []);
  if (open_picker.value !== null)
    return (
      <StopPicker
        title={
          open_picker.value === "pickup"
            ? texts.value.choose_pickup
            : texts.value.choose_destination
        }
        stops={campus.stops}
        pickup={pickup.value}
        destination={destination.value}
        onChoose={(stop_id) => {
          const end = open_picker.value ?? "pickup";
          chooseStop(end, stop_id);
          next_focus.value = destination.value === "" ? "destination" : end;
          open_picker.value = null;
        }}
        onBack={() => {
          next_focus.value = open_picker.value;
          open_picker.value = null;
        }}
      />
    );
  return (
    <BookingForm
      campus={campus}
      focus={next_focus.value}
      onPick={(end) => {
        open_picker.value = end;
      }}
    />
  );
}

const missing_stop = signal(false);
let is_link_read = false;

/** Once for each visit: what the passenger changes afterwards is theirs. */
function readLink(campus: Campus): void {
  if (!is_link_read) missing_stop.value = fillFromLink(location.search, campus.stops);
  is_link_read = true;
}

interface BookingFormProps {
  readonly campus: Campus;
  /** The field that gets the focus when the form appears. */
  readonly focus: RideEnd | null;
  readonly onPick: (end: RideEnd) => void;
}

function BookingForm({ campus, focus, onPick }: BookingFormProps) {
  const busy = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const { timezone, seats_max, wheelchairs_max } = campus.view;
  const views = laterViews.value;
  const is_ready =
    canBook.value &&
    (isRecurring.value ? isSeriesRequestValid(timezone) : isPickupTimeValid(timezone));
  const submit = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    problem.value = null;
    problem.value = await (isRecurring.value ? submitSeries() : submitRide(timezone));
    busy.value = false;
  };
  const again = async (trip: LastTrip) => {
    fillTrip(trip);
    busy.value = true;
    problem.value = null;
    problem.value = await submitRide(timezone);
    busy.value = false;
  };
  return (
    <form class="booking" onSubmit={(event) => void submit(event)}>
      <h1>{t.book_title}</h1>
      <CurrentRideAlert />
      <ServiceAlert campus={campus} />
      {views !== null && (
        <views.AnnouncementList
          timezone={timezone}
          stop_ids={[pickup.value, destination.value].filter((stop_id) => stop_id !== "")}
          vehicle_id={null}
        />
      )}
      {missing_stop.value && <Alert tone="warning">{t.link_stop_missing}</Alert>}
      {!canBook.value && (
        <LastTripList campus={campus} disabled={busy.value} onBook={(trip) => void again(trip)} />
      )}
      <StopFields campus={campus} focus={focus} onPick={onPick} />
      <QuickStops campus={campus} />
      <div class="field-pair">
        <Stepper
          label={t.people}
          value={party.value}
          min={1}
          max={seats_max}
          fewer={t.fewer}
          more={t.more}
          onChange={setParty}
        />
        <Stepper
          label={t.wheelchairs}
          value={wheelchairs.value}
          min={0}
          max={Math.min(party.value, wheelchairs_max)}
          fewer={t.fewer}
          more={t.more}
          onChange={(count) => {
            wheelchairs.value = count;
          }}
        />
      </div>
      {party.value > wheelchairs_max && wheelchairs.value === wheelchairs_max && (
        <p class="hint">{t.wheelchair_places(wheelchairs_max)}</p>
      )}
      <PickupTimeField view={campus.view} />
      {!isRecurring.value && (
        <label class="walk-option">
          <input
            type="checkbox"
            checked={mayWalk.value}
            onChange={(event) => {
              mayWalk.value = event.currentTarget.checked;
            }}
          />
          {t.may_walk}
        </label>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      <div class={canBook.value ? "book-bar" : "book-bar waiting"}>
        <button class="button main large wide" disabled={!is_ready || busy.value}>
          {busy.value
            ? t.booking
            : !canBook.value
              ? t.both_stops_first
              : isRecurring.value
                ? t.book_series
                : t.book}
        </button>
      </div>
      <div class="more-links">
        <button
          type="button"
          class="button quiet small"
          onClick={() => goTo({ view: "find", code: "" })}
        >
          {t.have_code}
        </button>
        {campus.view.has_timetable && (
          <button
            type="button"
            class="button quiet small"
            onClick={() => goTo({ view: "timetable" })}
          >
            {t.timetable}
          </button>
        )}
        <CurrentSeriesButton />
      </div>
    </form>
  );
}

async function submitRide(timezone: string): Promise<Problem | null> {
  const trip = currentTrip();
  const result = await bookRide(timezone);
  if (!result.ok) return result.problem;
  if (result.value.state !== "refused") rememberTrip(trip);
  if (result.value.state !== "refused") storeRideToken(result.value.token);
  goTo({ view: "ride", token: result.value.token });
  return null;
}

async function submitSeries(): Promise<Problem | null> {
  const result = await bookSeries();
  if (!result.ok) return result.problem;
  storeSeriesToken(result.value.token);
  isRecurring.value = false;
  goTo({ view: "series", token: result.value.token });
  return null;
}

function StopFields({ campus, focus, onPick }: BookingFormProps) {
  const t = texts.value;
  const fields = {
    pickup: useRef<HTMLButtonElement>(null),
    destination: useRef<HTMLButtonElement>(null),
  };
  useEffect(() => {
    if (focus !== null) fields[focus].current?.focus();
  }, []);
  const name = (stop_id: string) => stopNameById(campus.stops, stop_id, language.value);
  return (
    <div class="stop-fields card">
      <button ref={fields.pickup} type="button" class="stop-field" onClick={() => onPick("pickup")}>
        <PickupIcon />
        <span>
          <small>{t.from}</small>
          {pickup.value === "" ? <em>{t.choose_pickup}</em> : name(pickup.value)}
        </span>
      </button>
      <button
        ref={fields.destination}
        type="button"
        class="stop-field"
        onClick={() => onPick("destination")}
      >
        <DestinationIcon />
        <span>
          <small>{t.to}</small>
          {destination.value === "" ? <em>{t.choose_destination}</em> : name(destination.value)}
        </span>
      </button>
      <button type="button" class="swap" aria-label={t.swap} title={t.swap} onClick={swapEnds}>
        <SwapIcon />
      </button>
    </div>
  );
}
