import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { second } from "../../shared/live/clock";
import { conditionOf } from "../../shared/scene/condition";
import { language } from "../../shared/texts/language";
import { momentNear } from "../../shared/texts/times";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { clearEnds } from "../booking/ride_request";
import { StopPicker } from "../booking/stop_picker";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { Alternatives } from "./alternative_list";
import { RideActions } from "./ride_actions";
import type { Story } from "./ride_progress";
import { minutesUntil } from "./ride_progress";
import type { FollowedRide, Ticket } from "./ride_tracker";
import { TicketCard } from "./ticket_card";

interface RidePanelProps {
  readonly ride: FollowedRide;
  readonly campus: Campus;
}

export function RidePanel({ ride, campus }: RidePanelProps) {
  const [ticket, story] = [ride.ticket.value, ride.story.value];
  const redirecting = useSignal(false);
  const t = texts.value;
  if (ride.problem.value !== null)
    return (
      <section class="ride">
        <ProblemNote problem={ride.problem.value} />
        <BookAnother />
      </section>
    );
  if (ticket === null || story === null) return <Loading text={t.looking_up_ride} />;
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
  const t = texts.value;
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
        title={busy.value ? t.changing_destination : t.choose_destination}
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
  return ride.vehicle.value?.name ?? ticket.vehicle_id ?? texts.value.shuttle;
}

/** The headline with its time, which changes every minute. */
function titleOf(ride: FollowedRide, ticket: Ticket, story: Story, timezone: string): string {
  const t = texts.value;
  const { chapter, eta_ms } = story;
  if (eta_ms === null || (chapter !== "coming" && chapter !== "riding"))
    return plainTitle(story, ride, ticket);
  const now_ms = second.value > 0 ? (ride.link.now_ms() ?? Date.now()) : Date.now();
  const minutes = minutesUntil(eta_ms, now_ms);
  const name = vehicleName(ride, ticket);
  if (minutes >= 60) {
    const time = momentNear(eta_ms, now_ms, language.value, timezone);
    return chapter === "coming" ? t.coming_at(name, time) : t.riding_at(time);
  }
  const soon = minutes === 0 ? t.under_a_minute : t.in_minutes(minutes);
  return chapter === "coming" ? t.coming_in(name, soon) : t.riding_in(soon);
}

/** The headline without times: what a screen reader is told, once for each change. */
function plainTitle(story: Story, ride: FollowedRide, ticket: Ticket): string {
  const t = texts.value;
  switch (story.chapter) {
    case "coming":
      return t.coming(vehicleName(ride, ticket));
    case "here":
      return t.here(vehicleName(ride, ticket));
    default:
      return t[story.chapter];
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
  const t = texts.value;
  const text = detailOf(ticket, story);
  const delay = delayOf(ride, story);
  return (
    <>
      {text !== "" && <p class="lead">{text}</p>}
      {ticket.let_out && !story.ended && <Note tone="good">{t.let_out}</Note>}
      {ticket.stranded_by !== null && !story.ended && story.chapter !== "riding" && (
        <Note tone="warning">{t.stranded}</Note>
      )}
      {ticket.promise_broken && (
        <Note tone="warning">{ticket.first_promise == null ? t.late : t.promised_anew}</Note>
      )}
      {delay !== "" && <Note tone="warning">{delay}</Note>}
    </>
  );
}

function detailOf(ticket: Ticket, story: Story): string {
  const t = texts.value;
  switch (story.chapter) {
    case "looking":
      return t.looking_more;
    case "here":
      return t.here_more;
    case "arrived":
      return t.arrived_more;
    case "done":
      return ticket.left_early ? t.done_early : t.done_more;
    case "refused":
      return t.reasons[ticket.reason] ?? ticket.reason_detail;
    case "cancelled":
      return ticket.reason === "cancelled_by_operator" ? t.cancelled_operator : "";
    case "missed":
      return t.missed_more;
    case "failed":
      return t.failed_more;
    default:
      return "";
  }
}

/** Why the shuttle does not move, when that needs an explanation. */
function delayOf(ride: FollowedRide, story: Story): string {
  const vehicle = ride.vehicle.value;
  if (vehicle === null || (story.chapter !== "coming" && story.chapter !== "riding")) return "";
  const t = texts.value;
  switch (conditionOf(vehicle)) {
    case "offline":
      return t.out_of_reach;
    case "held":
    case "manual":
    case "fault":
    case "minimal_risk":
      return t.held;
    case "blocked":
      return t.waits_for_person;
    case "waiting":
      return t.waits_for_road;
    default:
      return "";
  }
}

function LinkNote({ ride, story }: { readonly ride: FollowedRide; readonly story: Story }) {
  const state = ride.link.state.value;
  const heard_ms = ride.link.heard_ms.value;
  if (state === "open" || story.ended) return null;
  const t = texts.value;
  if (state === "refused") return <Note>{t.link_refused}</Note>;
  if (state === "connecting" || heard_ms === null) return <Note>{t.connecting}</Note>;
  const ago_s = Math.max(0, Math.round((second.value - heard_ms) / 1000));
  return (
    <div class="note warning" data-stale>
      {t.last_seen(ago_s)}
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
      {keep ? texts.value.change_booking : texts.value.book_another}
    </button>
  );
}
