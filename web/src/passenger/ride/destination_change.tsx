import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { ProblemAlert } from "../../shared/ui/alerts";
import { StopPicker } from "../booking/stop_picker";
import { texts } from "../texts/texts";
import type { RideTracker, Ticket } from "./ride_tracker";

interface DestinationChangeProps {
  readonly ride: RideTracker;
  readonly ticket: Ticket;
  readonly campus: Campus;
  readonly onDone: () => void;
}

/** A new destination. The server refuses it, and changes nothing, if it would break another ride's promise. */
export function DestinationChange({ ride, ticket, campus, onDone }: DestinationChangeProps) {
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
  const choices = campus.stops.filter(
    (stop) => ticket.state === "aboard" || stop.stop_id !== ticket.from_stop,
  );
  return (
    <>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
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
