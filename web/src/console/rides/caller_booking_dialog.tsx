import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import { idempotencyKey } from "../../shared/api/idempotency_key";
import type { Problem } from "../../shared/api/problem";
import { campus } from "../../shared/campus/campus";
import { ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { goTo } from "../navigation";
import { rides } from "../store/rides";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTime } from "../texts/times";

type Booking = Schemas["CallerBooking"];
type Alternative = Schemas["AlternativeView"];

/** Books for somebody who calls, and says what to tell the caller: the codes and times, or an alternative. */
export function CallerBookingDialog({ onClose }: { readonly onClose: () => void }) {
  const t = texts.value;
  const from_stop = useSignal("");
  const to_stop = useSignal("");
  const party = useSignal("1");
  const wheelchairs = useSignal("0");
  const answer = useSignal<Booking | null>(null);
  const problem = useSignal<Problem | null>(null);
  const is_sending = useSignal(false);
  // One key for one wish: pressing twice, or again after a lost answer, books once.
  const key = useSignal(idempotencyKey());
  const stops = [
    ["", t.choose_stop] as const,
    ...(campus.value?.geometry.stops ?? []).map(
      (stop) => [stop.stop_id, stopName(stop.stop_id)] as const,
    ),
  ];
  const changed = () => {
    key.value = idempotencyKey();
    answer.value = null;
  };
  const book = async (earliest: string | null = null) => {
    is_sending.value = true;
    const result = await resultOf(
      api.POST("/api/v1/rides/for-caller", {
        params: { header: { "idempotency-key": key.value } },
        body: {
          from_stop: from_stop.value,
          to_stop: to_stop.value,
          party: Number(party.value),
          wheelchairs: Number(wheelchairs.value),
          earliest,
          may_walk: false,
        },
      }),
    );
    is_sending.value = false;
    problem.value = result.ok ? null : result.problem;
    if (!result.ok) return;
    answer.value = result.value;
    key.value = idempotencyKey();
    await rides.refresh();
  };
  const take = (alternative: Alternative) => {
    from_stop.value = alternative.from_stop;
    to_stop.value = alternative.to_stop;
    void book(alternative.kind === "later" ? alternative.pickup_at[0]! : null);
  };
  const ride = answer.value?.ride;
  return (
    <Dialog title={t.book_for_caller} onClose={onClose}>
      <form
        class="stack"
        onSubmit={(event) => {
          event.preventDefault();
          void book();
        }}
      >
        <SelectField
          label={t.ride_from}
          value={from_stop.value}
          options={stops}
          onChange={(chosen) => {
            from_stop.value = chosen;
            changed();
          }}
        />
        <SelectField
          label={t.ride_to}
          value={to_stop.value}
          options={stops}
          onChange={(chosen) => {
            to_stop.value = chosen;
            changed();
          }}
        />
        <TextField
          label={t.people}
          value={party}
          input={{ type: "number", min: 1, max: 20, required: true }}
        />
        <TextField
          label={t.wheelchairs}
          value={wheelchairs}
          input={{ type: "number", min: 0, max: 20, required: true }}
        />
        {problem.value !== null && <ProblemAlert problem={problem.value} />}
        {ride !== undefined && <Answer ride={ride} />}
        {(answer.value?.alternatives ?? []).map((alternative) => (
          <AlternativeRow
            key={`${alternative.kind} ${alternative.from_stop} ${alternative.to_stop} ${alternative.pickup_at[0]}`}
            alternative={alternative}
            onTake={take}
          />
        ))}
        <div class="dialog-buttons">
          <button type="button" class="button" onClick={onClose}>
            {t.cancel}
          </button>
          {ride !== undefined && ride.state !== "refused" ? (
            <button type="button" class="button main" onClick={() => goTo("rides", ride.ride_id)}>
              {t.show_ride}
            </button>
          ) : (
            <button
              class="button main"
              disabled={is_sending.value || from_stop.value === "" || to_stop.value === ""}
            >
              {t.book}
            </button>
          )}
        </div>
      </form>
    </Dialog>
  );
}

function Answer({ ride }: { readonly ride: Schemas["RideRecord"] }) {
  const t = texts.value;
  if (ride.state === "refused" || ride.promise === null)
    return (
      <p role="status" class="chip warning">
        {t.states.refused}: {t.reasons[ride.reason] ?? ride.reason_detail}
      </p>
    );
  return (
    <p role="status" data-ride-code={ride.ride_code}>
      {t.tell_caller(
        ride.ride_code,
        ride.boarding_code,
        formatTime(ride.promise.pickup_from),
        formatTime(ride.promise.pickup_to),
        formatTime(ride.promise.arrive_by),
      )}
    </p>
  );
}

/** A party that would be split needs two bookings: the operator makes them one by one. */
function AlternativeRow({
  alternative,
  onTake,
}: {
  readonly alternative: Alternative;
  readonly onTake: (alternative: Alternative) => void;
}) {
  const t = texts.value;
  return (
    <p class="alternative">
      <span>
        {t.alternatives[alternative.kind]}: {stopName(alternative.from_stop)} –{" "}
        {stopName(alternative.to_stop)}, {alternative.pickup_at.map(formatTime).join(", ")}
        {alternative.parties.length > 1 && ` (${alternative.parties.join(" + ")})`}
      </span>
      {alternative.kind !== "split_party" && (
        <button type="button" class="button small" onClick={() => onTake(alternative)}>
          {t.book_this}
        </button>
      )}
    </p>
  );
}
