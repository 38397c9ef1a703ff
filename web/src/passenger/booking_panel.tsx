import { useSignal } from "@preact/signals";
import type { Campus } from "../shared/api/campus";
import type { Problem } from "../shared/api/problem";
import { nameOfStop } from "../shared/map/campus_shape";
import { DestinationMark, PickupMark, SwapIcon } from "../shared/ui/icons";
import { Note, ProblemNote } from "../shared/ui/notes";
import { Stepper } from "../shared/ui/stepper";
import { language } from "../shared/words/language";
import { momentNear } from "../shared/words/moments";
import type { End } from "./booking_form";
import {
  book,
  canBook,
  destination,
  party,
  pickup,
  setParty,
  swapEnds,
  wheelchairs,
} from "./booking_form";
import { lastRideToken, rememberRide } from "./followed_ride";
import { goTo } from "./navigation";
import { StopPicker } from "./stop_picker";
import { WhenField, timeIsUsable } from "./when_field";
import { words } from "./words";

export function BookingPanel({ campus }: { readonly campus: Campus }) {
  const picking = useSignal<End | null>(null);
  if (picking.value !== null)
    return (
      <StopPicker
        end={picking.value}
        stops={campus.shape.stops}
        onDone={() => {
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
  const is_ready = canBook.value && timeIsUsable(timezone);
  const submit = async (event: Event) => {
    event.preventDefault();
    busy.value = true;
    problem.value = null;
    const answer = await book(timezone);
    busy.value = false;
    if (!answer.ok) {
      problem.value = answer.problem;
      return;
    }
    if (answer.value.state !== "refused") rememberRide(answer.value.token);
    goTo({ view: "ride", token: answer.value.token });
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
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      <div class="book-bar">
        <button class="button main large wide" disabled={!is_ready || busy.value}>
          {busy.value ? say.booking : canBook.value ? say.book : say.both_stops_first}
        </button>
      </div>
      <button
        type="button"
        class="button quiet small"
        onClick={() => goTo({ view: "find", code: "" })}
      >
        {say.have_code}
      </button>
    </form>
  );
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

function ServiceNote({ campus }: { readonly campus: Campus }) {
  const { open_now, opens_next, now, timezone } = campus.view;
  if (open_now) return null;
  return (
    <Note tone="warning">
      {opens_next === null
        ? words.value.closed
        : words.value.closed_until(momentNear(opens_next, now, language.value, timezone))}
    </Note>
  );
}
