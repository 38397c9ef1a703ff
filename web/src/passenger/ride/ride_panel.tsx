import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { monotonic_ms } from "../../shared/live/clock";
import { language } from "../../shared/texts/language";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { AnnouncementList } from "../announcements/announcement_list";
import { clearEnds } from "../booking/ride_request";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { AlternativeList } from "./alternative_list";
import { showArrival } from "./arrival_signs";
import { DestinationChange } from "./destination_change";
import { RideActions } from "./ride_actions";
import { FeedbackForm } from "./feedback_form";
import { canWait, FreeShuttle } from "./free_shuttle";
import { arrivalOfWaiting, factsOf, type RideProgress } from "./ride_progress";
import { announcedText, delayText, detailText, titleWithTime, vehicleName } from "./ride_texts";
import type { RideTracker, Ticket } from "./ride_tracker";
import { TicketCard } from "./ticket_card";

interface RidePanelProps {
  readonly ride: RideTracker;
  readonly campus: Campus;
}

export function RidePanel({ ride, campus }: RidePanelProps) {
  const [ticket, progress] = [ride.ticket.value, ride.progress.value];
  useEffect(() => showArrival(ride), [ride]);
  const changing_destination = useSignal(false);
  const is_free = useSignal(false);
  if (ride.problem.value !== null)
    return (
      <section class="ride">
        <h1>{texts.value.no_ride}</h1>
        <ProblemAlert problem={ride.problem.value} />
        <BookAnotherButton />
      </section>
    );
  if (ticket === null || progress === null) return <Loading text={texts.value.loading_ride} />;
  if (changing_destination.value && progress.can_change_destination)
    return (
      <DestinationChange
        ride={ride}
        ticket={ticket}
        campus={campus}
        onDone={() => {
          changing_destination.value = false;
        }}
      />
    );
  return (
    <section class="ride">
      <FocusedTitle>{titleWithTime(ride, progress, campus.view.timezone)}</FocusedTitle>
      <p class="visually-hidden" role="status">
        {announcedText(progress, vehicleName(ride))}
      </p>
      {!progress.ended && (
        <AnnouncementList
          timezone={campus.view.timezone}
          stop_ids={[ticket.from_stop, ticket.to_stop]}
          vehicle_id={ride.vehicle.value?.vehicle_id ?? ticket.vehicle_id ?? null}
        />
      )}
      <RideDetails ride={ride} ticket={ticket} progress={progress} campus={campus} />
      <ConnectionAlert ride={ride} progress={progress} />
      {ticket.promise !== null && (
        <TicketCard
          ticket={ticket}
          seats_left={ride.live.value === null ? ticket.seats_left : ride.live.value.seats_left}
          vehicle={vehicleName(ride)}
          from={stopNameById(campus.stops, ticket.from_stop, language.value)}
          to={stopNameById(campus.stops, ticket.to_stop, language.value)}
          view={campus.view}
          ended={progress.ended}
          arrival={arrivalOfWaiting(factsOf(ticket, ride.live.value))}
        />
      )}
      {progress.phase === "refused" && canWait(ticket, campus.view.wheelchairs_max) && (
        <FreeShuttle
          key={ticket.ride_id}
          ticket={ticket}
          campus={campus}
          onFree={(now_free) => {
            is_free.value = now_free;
          }}
        />
      )}
      <AlternativeList ticket={ticket} campus={campus} />
      {progress.ended && ticket.boarded_at !== null && (
        <FeedbackForm key={ticket.ride_id} ride={ride} ticket={ticket} />
      )}
      {progress.ended ? (
        <BookAnotherButton keep={progress.phase === "refused"} is_strong={!is_free.value} />
      ) : (
        <RideActions
          ride={ride}
          progress={progress}
          onChangeDestination={() => {
            changing_destination.value = true;
          }}
        />
      )}
    </section>
  );
}

/** After a booking the focus is on the answer; the button that had it is gone. */
function FocusedTitle({ children }: { readonly children: string }) {
  const title = useRef<HTMLHeadingElement>(null);
  useEffect(() => {
    if (document.activeElement === document.body) title.current?.focus();
  }, []);
  return (
    <h1 ref={title} tabIndex={-1}>
      {children}
    </h1>
  );
}

interface RideDetailsProps {
  readonly ride: RideTracker;
  readonly ticket: Ticket;
  readonly progress: RideProgress;
  readonly campus: Campus;
}

function RideDetails({ ride, ticket, progress, campus }: RideDetailsProps) {
  const t = texts.value;
  const detail = detailText(ticket, progress, campus.view.wheelchairs_max);
  const delay = delayText(ride, progress, campus.view.timezone);
  return (
    <>
      {detail !== "" && <p class="lead">{detail}</p>}
      {ticket.let_out && !progress.ended && <Alert tone="good">{t.let_out}</Alert>}
      {ticket.stranded_by !== null && !progress.ended && progress.phase !== "aboard" && (
        <Alert tone="warning">{t.stranded}</Alert>
      )}
      {ticket.promise_broken && !progress.ended && (
        <Alert tone="warning">
          {ticket.first_promise == null ? t.promise_broken : t.promise_renewed}
        </Alert>
      )}
      {delay !== "" && <Alert tone="warning">{delay}</Alert>}
    </>
  );
}

function ConnectionAlert({ ride, progress }: Omit<RideDetailsProps, "ticket" | "campus">) {
  const state = ride.link.state.value;
  const news_came_ms = ride.news_came_ms.value;
  if (state === "open" || progress.ended) return null;
  const t = texts.value;
  if (state === "refused") return <Alert>{t.link_refused}</Alert>;
  if (news_came_ms === null) return <Alert>{t.connecting}</Alert>;
  const age_s = Math.max(0, Math.round((monotonic_ms.value - news_came_ms) / 1000));
  return (
    <div class="alert warning" data-stale>
      {t.last_seen(age_s)}
    </div>
  );
}

interface BookAnotherProps {
  /** The refused request stays filled in, so that the passenger can change it. */
  readonly keep?: boolean;
  readonly is_strong?: boolean;
}

function BookAnotherButton({ keep = false, is_strong = true }: BookAnotherProps) {
  return (
    <button
      type="button"
      class={is_strong ? "button main large wide" : "button wide"}
      onClick={() => {
        if (!keep) clearEnds();
        goTo({ view: "book" });
      }}
    >
      {keep ? texts.value.change_booking : texts.value.book_another}
    </button>
  );
}
