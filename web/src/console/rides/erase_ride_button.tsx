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

/** Takes out of the record who rode. Only of a ride that has ended, and for good. */
export function EraseRideButton({ ride }: { readonly ride: Schemas["RideRecord"] }) {
  const confirming = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const t = texts.value;
  if (!hasEnded(ride.state) || ride.ride_code === "" || !may("admin")) return null;
  const erase = async () => {
    confirming.value = false;
    const path = { params: { path: { ride_id: ride.ride_id } } };
    const result = await resultOf(api.POST("/api/v1/rides/id/{ride_id}/erase", path));
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
        {t.erase_ride}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {confirming.value && (
        <ConfirmDialog
          danger
          title={t.erase_ride_title(ride.ride_code)}
          text={t.erase_ride_text}
          yes={t.erase_ride_yes}
          no={t.cancel}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => void erase()}
        />
      )}
    </>
  );
}
