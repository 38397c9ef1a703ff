import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { hasEnded } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { may } from "../session";
import { rides } from "../store/rides";
import { texts } from "../texts/texts";

/** Cancels a ride; a ride that is aboard ends at the next possible stop. */
export function CancelRideButton({ ride }: { readonly ride: Schemas["RideRecord"] }) {
  const confirming = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  const is_aboard = ride.state === "aboard";
  if (hasEnded(ride.state) || ride.let_out || !may("dispatcher")) return null;
  const cancel = async () => {
    confirming.value = false;
    const path = { params: { path: { ride_id: ride.ride_id } } };
    const result = await resultOf(api.POST("/api/v1/rides/id/{ride_id}/cancel", path));
    problem.value = result.ok ? null : result.problem;
    await rides.refresh();
  };
  return (
    <>
      <button
        type="button"
        class="button small"
        onClick={() => {
          confirming.value = true;
        }}
      >
        {is_aboard ? t.let_out : t.cancel_ride}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {confirming.value && (
        <ConfirmDialog
          danger
          title={is_aboard ? t.let_out_title(ride.ride_code) : t.cancel_ride_title(ride.ride_code)}
          text={is_aboard ? t.let_out_text : t.cancel_ride_text}
          yes={is_aboard ? t.let_out : t.cancel_ride_yes}
          no={t.cancel}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </>
  );
}
