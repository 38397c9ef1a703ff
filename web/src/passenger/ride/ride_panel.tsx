import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_shape";
import { second } from "../../shared/live/clock";
import { conditionOf } from "../../shared/scene/condition";
import { Loading, Note, ProblemNote } from "../../shared/ui/notes";
import { language } from "../../shared/words/language";
import { momentNear } from "../../shared/words/moments";
import { clearEnds } from "../booking/booking_form";
import { StopPicker } from "../booking/stop_picker";
import { goTo } from "../navigation";
import { words } from "../texts/words";
import { Alternatives } from "./alternatives";
import type { FollowedRide, Ticket } from "./followed_ride";
import { RideActions } from "./ride_actions";
import type { Story } from "./ride_story";
import { minutesUntil } from "./ride_story";
import { TicketCard } from "./ticket_card";

interface RidePanelProps {
  readonly ride: FollowedRide;
  readonly campus: Campus;
}

export function RidePanel({ ride, campus }: RidePanelProps) {
  const [ticket, story] = [ride.ticket.value, ride.story.value];
  const redirecting = useSignal(false);
  const say = words.value;
  if (ride.problem.value !== null)
    return (
      <section class="ride">
        <ProblemNote problem={ride.problem.value} />
        <BookAnother />
      </section>
    );
  if (ticket === null || story === null) return <Loading text={say.looking_up_ride} />;
  if (redirecting.value && story.can_redirect)
    return (
      <Redirect
        ride={ride}
        ticket={ticket}
        campus={campus}
        onDone={() => {
          redirecting.value = false;
        }}
      />
    );
  const title = titleOf(ride, ticket, story, campus.view.timezone);
  return (
    <section class="ride">
      <p class="unseen" role="status">
        {plainTitle(story, ride, ticket)}
      </p>
      <h1>{title}</h1>
      <Details ride={ride} ticket={ticket} story={story} />
      <LinkNote ride={ride} story={story} />
      {ticket.promise !== null && (
        <TicketCard
          ticket={ticket}
          vehicle={vehicleName(ride, ticket)}
          from={nameOfStop(campus.shape.stops, ticket.from_stop, language.value)}
          to={nameOfStop(campus.shape.stops, ticket.to_stop, language.value)}
          view={campus.view}
          ended={story.ended}
        />
      )}
      <Alternatives ticket={ticket} campus={campus} />
      {story.ended ? (
        <BookAnother keep={story.chapter === "refused"} />
      ) : (
        <RideActions
          ride={ride}
          story={story}
          onRedirect={() => {
            redirecting.value = true;
          }}
        />
      )}
    </section>
  );
}

interface RedirectProps extends RidePanelProps {
  readonly ticket: Ticket;
  readonly onDone: () => void;
}

/** Another destination: refused where it would break somebody else's promise, and nothing is changed then. */
function Redirect({ ride, ticket, campus, onDone }: RedirectProps) {
  const problem = useSignal<Problem | null>(null);
  const busy = useSignal(false);
  const say = words.value;
  const choose = async (to_stop: string) => {
    if (busy.value) return;
    busy.value = true;
    problem.value = await ride.changeDestination(to_stop);
    busy.value = false;
    if (problem.value === null) onDone();
  };
  const choices = campus.shape.stops.filter(
    (stop) => ticket.state === "aboard" || stop.stop_id !== ticket.from_stop,
  );
  return (
    <>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      <StopPicker
        title={busy.value ? say.changing_destination : say.choose_destination}
        stops={choices}
        pickup={ticket.from_stop}
        destination={ticket.to_stop}
        onChoose={(stop_id) => void choose(stop_id)}
        onBack={onDone}
      />
    </>
  );
}

function vehicleName(ride: FollowedRide, ticket: Ticket): string {
  return ride.vehicle.value?.name ?? ticket.vehicle_id ?? words.value.shuttle;
}

/** The headline with its time, which changes every minute. */
function titleOf(ride: FollowedRide, ticket: Ticket, story: Story, timezone: string): string {
  const say = words.value;
  const { chapter, eta_ms } = story;
  if (eta_ms === null || (chapter !== "coming" && chapter !== "riding"))
    return plainTitle(story, ride, ticket);
  const now_ms = second.value > 0 ? (ride.link.now_ms() ?? Date.now()) : Date.now();
  const minutes = minutesUntil(eta_ms, now_ms);
  const name = vehicleName(ride, ticket);
  if (minutes >= 60) {
    const time = momentNear(eta_ms, now_ms, language.value, timezone);
    return chapter === "coming" ? say.coming_at(name, time) : say.riding_at(time);
  }
  const soon = minutes === 0 ? say.under_a_minute : say.in_minutes(minutes);
  return chapter === "coming" ? say.coming_in(name, soon) : say.riding_in(soon);
}

/** The headline without times: what a screen reader is told, once for each change. */
function plainTitle(story: Story, ride: FollowedRide, ticket: Ticket): string {
  const say = words.value;
  switch (story.chapter) {
    case "coming":
      return say.coming(vehicleName(ride, ticket));
    case "here":
      return say.here(vehicleName(ride, ticket));
    default:
      return say[story.chapter];
  }
}

function Details({
  ride,
  ticket,
  story,
}: {
  readonly ride: FollowedRide;
  readonly ticket: Ticket;
  readonly story: Story;
}) {
  const say = words.value;
  const text = detailOf(ticket, story);
  const delay = delayOf(ride, story);
  return (
    <>
      {text !== "" && <p class="lead">{text}</p>}
      {ticket.let_out && !story.ended && <Note tone="good">{say.let_out}</Note>}
      {ticket.stranded_by !== null && !story.ended && story.chapter !== "riding" && (
        <Note tone="warning">{say.stranded}</Note>
      )}
      {ticket.promise_broken && (
        <Note tone="warning">{ticket.first_promise == null ? say.late : say.promised_anew}</Note>
      )}
      {delay !== "" && <Note tone="warning">{delay}</Note>}
    </>
  );
}

function detailOf(ticket: Ticket, story: Story): string {
  const say = words.value;
  switch (story.chapter) {
    case "looking":
      return say.looking_more;
    case "here":
      return say.here_more;
    case "arrived":
      return say.arrived_more;
    case "done":
      return ticket.left_early ? say.done_early : say.done_more;
    case "refused":
      return say.reasons[ticket.reason] ?? ticket.reason_detail;
    case "cancelled":
      return ticket.reason === "cancelled_by_operator" ? say.cancelled_operator : "";
    case "missed":
      return say.missed_more;
    case "failed":
      return say.failed_more;
    default:
      return "";
  }
}

/** Why the shuttle does not move, when that needs an explanation. */
function delayOf(ride: FollowedRide, story: Story): string {
  const vehicle = ride.vehicle.value;
  if (vehicle === null || (story.chapter !== "coming" && story.chapter !== "riding")) return "";
  const say = words.value;
  switch (conditionOf(vehicle)) {
    case "offline":
      return say.out_of_reach;
    case "held":
    case "manual":
    case "fault":
    case "minimal_risk":
      return say.held;
    case "blocked":
      return say.waits_for_person;
    case "waiting":
      return say.waits_for_road;
    default:
      return "";
  }
}

function LinkNote({ ride, story }: { readonly ride: FollowedRide; readonly story: Story }) {
  const state = ride.link.state.value;
  const heard_ms = ride.link.heard_ms.value;
  if (state === "open" || story.ended) return null;
  const say = words.value;
  if (state === "refused") return <Note>{say.link_refused}</Note>;
  if (state === "connecting" || heard_ms === null) return <Note>{say.connecting}</Note>;
  const ago_s = Math.max(0, Math.round((second.value - heard_ms) / 1000));
  return (
    <div class="note warning" data-stale>
      {say.last_seen(ago_s)}
    </div>
  );
}

/** keep: what was asked for stays filled in, to be changed where it was refused. */
function BookAnother({ keep = false }: { readonly keep?: boolean }) {
  return (
    <button
      type="button"
      class="button main large wide"
      onClick={() => {
        if (!keep) clearEnds();
        goTo({ view: "book" });
      }}
    >
      {keep ? words.value.change_booking : words.value.book_another}
    </button>
  );
}
