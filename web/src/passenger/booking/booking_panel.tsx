import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_shape";
import { DestinationMark, PickupMark, SwapIcon } from "../../shared/ui/icons";
import { Note, ProblemNote } from "../../shared/ui/notes";
import { Stepper } from "../../shared/ui/stepper";
import { language } from "../../shared/words/language";
import { clockTime, momentNear } from "../../shared/words/moments";
import { goTo } from "../navigation";
import { words } from "../texts/words";
import { lastRideToken, lastSeriesToken, rememberRide, rememberSeries } from "../token_storage";
import type { End } from "./booking_form";
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
} from "./booking_form";
import { bookSeries, repeatIsUsable, repeating } from "./repeat_form";
import { StopPicker } from "./stop_picker";
import { WhenField, timeIsUsable } from "./when_field";

const SOON_MS = 60 * 60_000;

export function BookingPanel({ campus }: { readonly campus: Campus }) {
  const picking = useSignal<End | null>(null);
  if (picking.value !== null)
    return (
      <StopPicker
        title={
          picking.value === "pickup" ? words.value.choose_pickup : words.value.choose_destination
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
  const say = words.value;
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
      <h1>{say.book_title}</h1>
      <RideUnderWay />
      <ServiceNote campus={campus} />
      <EndFields campus={campus} onPick={onPick} />
      <div class="two">
        <Stepper
          label={say.people}
          value={party.value}
          min={1}
          max={seats_max}
          fewer={say.fewer}
          more={say.more}
          onChange={setParty}
        />
        <Stepper
          label={say.wheelchairs}
          value={wheelchairs.value}
          min={0}
          max={party.value}
          fewer={say.fewer}
          more={say.more}
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
          {say.may_walk}
        </label>
      )}
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      <div class="book-bar">
        <button class="button main large wide" disabled={!is_ready || busy.value}>
          {busy.value
            ? say.booking
            : !canBook.value
              ? say.both_stops_first
              : repeating.value
                ? say.book_series
                : say.book}
        </button>
      </div>
      <div class="more-ways">
        <button
          type="button"
          class="button quiet small"
          onClick={() => goTo({ view: "find", code: "" })}
        >
          {say.have_code}
        </button>
        {campus.view.has_timetable && (
          <button
            type="button"
            class="button quiet small"
            onClick={() => goTo({ view: "timetable" })}
          >
            {say.timetable}
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
  const say = words.value;
  const name = (stop_id: string) => nameOfStop(campus.shape.stops, stop_id, language.value);
  return (
    <div class="ends card">
      <button type="button" class="end" onClick={() => onPick("pickup")}>
        <PickupMark />
        <span>
          <small>{say.from}</small>
          {pickup.value === "" ? <em>{say.choose_pickup}</em> : name(pickup.value)}
        </span>
      </button>
      <button type="button" class="end" onClick={() => onPick("destination")}>
        <DestinationMark />
        <span>
          <small>{say.to}</small>
          {destination.value === "" ? <em>{say.choose_destination}</em> : name(destination.value)}
        </span>
      </button>
      <button type="button" class="swap" aria-label={say.swap} title={say.swap} onClick={swapEnds}>
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
      <p>{words.value.current_ride}</p>
      <button type="button" class="button small" onClick={() => goTo({ view: "ride", token })}>
        {words.value.show_ride}
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
      {words.value.my_series}
    </button>
  );
}

function ServiceNote({ campus }: { readonly campus: Campus }) {
  const { open_now, opens_next, closes_at, holiday, now, timezone } = campus.view;
  if (open_now && closes_at !== null && Date.parse(closes_at) - Date.parse(now) < SOON_MS)
    return (
      <Note tone="warning">
        {words.value.closes_soon(clockTime(closes_at, language.value, timezone))}
      </Note>
    );
  if (open_now) return null;
  if (holiday !== null && opens_next !== null)
    return (
      <Note tone="warning">
        {words.value.closed_holiday(holiday, momentNear(opens_next, now, language.value, timezone))}
      </Note>
    );
  return (
    <Note tone="warning">
      {opens_next === null
        ? words.value.closed
        : words.value.closed_until(momentNear(opens_next, now, language.value, timezone))}
    </Note>
  );
}
