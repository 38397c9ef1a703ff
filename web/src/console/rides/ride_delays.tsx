import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { texts } from "../texts/texts";

/** Whom the ride delays. Asked for by a button: the server plans the shuttle once more for it. */
export function RideDelays({ ride_id }: { readonly ride_id: string }) {
  const t = texts.value;
  const delays = useSignal<readonly Schemas["RideDelayView"][] | null>(null);
  const problem = useSignal<Problem | null>(null);
  const ask = async () => {
    const params = { params: { path: { ride_id } } };
    const result = await resultOf(api.POST("/api/v1/rides/id/{ride_id}/delays", params));
    problem.value = result.ok ? null : result.problem;
    delays.value = result.ok ? result.value : null;
  };
  return (
    <section>
      <h2>{t.who_is_delayed}</h2>
      <button type="button" class="button" onClick={() => void ask()}>
        {t.compute_delays}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      <div role="status">
        {delays.value !== null && (
          <ul class="delays">
            {delays.value?.length === 0 && <li>{t.nobody_delayed}</li>}
            {delays.value?.map((one) => (
              <li key={one.ride_id}>
                <a href={fragmentOf("rides", one.ride_id)} class="mono">
                  {one.ride_code}
                </a>{" "}
                {t.delayed_by(Math.round(one.pickup_s), Math.round(one.arrival_s))}
              </li>
            ))}
          </ul>
        )}
      </div>
    </section>
  );
}
