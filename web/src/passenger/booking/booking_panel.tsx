import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { clockTime, momentNear } from "../../shared/texts/times";
import { Note, ProblemNote } from "../../shared/ui/alerts";
import { DestinationMark, PickupMark, SwapIcon } from "../../shared/ui/icons";
import { Stepper } from "../../shared/ui/stepper";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { lastRideToken, lastSeriesToken, rememberRide, rememberSeries } from "../token_storage";
import { WhenField, timeIsUsable } from "./pickup_time_field";
import type { End } from "./ride_request";
import {
  book,
  canBook,
  chooseStop,
  destination,
  mayWalk,
  party,
  pickup,
  setParty,
  swapEnds,
  wheelchairs,
} from "./ride_request";
import { bookSeries, repeatIsUsable, repeating } from "./series_request";
import { StopPicker } from "./stop_picker";

const SOON_MS = 60 * 60_000;

export function BookingPanel({ campus }: { readonly campus: Campus }) {
  const picking = useSignal<End | null>(null);
  if (picking.value !== null)
    return (
      <StopPicker
        title={
          picking.value === "pickup" ? texts.value.choose_pickup : texts.value.choose_destination
        }
        stops={campus.shape.stops}
        pickup={pickup.value}
        destination={destination.value}
        onChoose={(stop_id) => {
          chooseStop(picking.value ?? "pickup", stop_id);
          picking.value = null;
        }}
        onBack={() => {
          picking.value = null;
        }}
      />
    );
  return (
    <BookingForm
      campus={campus}
      onPick={(end) => {
        picking.value = end;
      }}
    />
  );
}

interface BookingFormProps {
  readonly campus: Campus;
  readonly onPick: (end: End) => void;
}

function BookingForm({ campus, onPick }: BookingFormProps) {
  const busy = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const { timezone, seats_max } = campus.view;
  const is_ready =
    canBook.value && (repeating.value ? repeatIsUsable(timezone) : timeIsUsable(timezone));
  const submit = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    problem.value = null;
    problem.value = await (repeating.value ? submitSeries() : submitRide(timezone));
    busy.value = false;
  };
  return (
    <form class="booking" onSubmit={(event) => void submit(event)}>
      <h1>{t.book_title}</h1>
      <RideUnderWay />
      <ServiceNote campus={campus} />
      <EndFields campus={campus} onPick={onPick} />
      <div class="two">
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
          max={party.value}
          fewer={t.fewer}
          more={t.more}
          onChange={(count) => {
            wheelchairs.value = count;
          }}
        />
      </div>
      <WhenField view={campus.view} />
      {!repeating.value && (
        <label class="walk">
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
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      <div class="book-bar">
        <button class="button main large wide" disabled={!is_ready || busy.value}>
          {busy.value
            ? t.booking
            : !canBook.value
              ? t.both_stops_first
              : repeating.value
                ? t.book_series
                : t.book}
        </button>
      </div>
      <div class="more-ways">
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
        <SeriesUnderWay />
      </div>
    </form>
  );
}

async function submitRide(timezone: string): Promise<Problem | null> {
  const answer = await book(timezone);
  if (!answer.ok) return answer.problem;
  if (answer.value.state !== "refused") rememberRide(answer.value.token);
  goTo({ view: "ride", token: answer.value.token });
  return null;
}

async function submitSeries(): Promise<Problem | null> {
  const answer = await bookSeries();
  if (!answer.ok) return answer.problem;
  rememberSeries(answer.value.token);
  repeating.value = false;
  goTo({ view: "series", token: answer.value.token });
  return null;
}

function EndFields({ campus, onPick }: BookingFormProps) {
  const t = texts.value;
  const name = (stop_id: string) => nameOfStop(campus.shape.stops, stop_id, language.value);
  return (
    <div class="ends card">
      <button type="button" class="end" onClick={() => onPick("pickup")}>
        <PickupMark />
        <span>
          <small>{t.from}</small>
          {pickup.value === "" ? <em>{t.choose_pickup}</em> : name(pickup.value)}
        </span>
      </button>
      <button type="button" class="end" onClick={() => onPick("destination")}>
        <DestinationMark />
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

function RideUnderWay() {
  const token = lastRideToken();
  if (token === null) return null;
  return (
    <Note>
      <p>{texts.value.current_ride}</p>
      <button type="button" class="button small" onClick={() => goTo({ view: "ride", token })}>
        {texts.value.show_ride}
      </button>
    </Note>
  );
}

function SeriesUnderWay() {
  const token = lastSeriesToken();
  if (token === null) return null;
  return (
    <button
      type="button"
      class="button quiet small"
      onClick={() => goTo({ view: "series", token })}
    >
      {texts.value.my_series}
    </button>
  );
}

function ServiceNote({ campus }: { readonly campus: Campus }) {
  const { open_now, opens_next, closes_at, holiday, now, timezone } = campus.view;
  if (open_now && closes_at !== null && Date.parse(closes_at) - Date.parse(now) < SOON_MS)
    return (
      <Note tone="warning">
        {texts.value.closes_soon(clockTime(closes_at, language.value, timezone))}
      </Note>
    );
  if (open_now) return null;
  if (holiday !== null && opens_next !== null)
    return (
      <Note tone="warning">
        {texts.value.closed_holiday(holiday, momentNear(opens_next, now, language.value, timezone))}
      </Note>
    );
  return (
    <Note tone="warning">
      {opens_next === null
        ? texts.value.closed
        : texts.value.closed_until(momentNear(opens_next, now, language.value, timezone))}
    </Note>
  );
}
