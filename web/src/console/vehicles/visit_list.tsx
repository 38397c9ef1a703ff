import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import { monotonic_ms } from "../../shared/live/clock";
import type { VehicleScene } from "../../shared/scene/scene";
import { ProblemAlert } from "../../shared/ui/alerts";
import { Resource } from "../store/resource";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTime } from "../texts/times";

const REFRESH_EVERY_S = 5;

/** The visits of the shuttle's order that are not done. */
export function VisitList({ vehicle }: { readonly vehicle: VehicleScene }) {
  const { vehicle_id } = vehicle;
  const detail = useMemo(
    () =>
      new Resource(() =>
        resultOf(api.GET("/api/v1/vehicles/{vehicle_id}", { params: { path: { vehicle_id } } })),
      ),
    [vehicle_id],
  );
  const ticks = useSignal(0);
  useSignalEffect(() => {
    if (monotonic_ms.value > 0 && (ticks.value = ticks.peek() + 1) % REFRESH_EVERY_S === 0)
      void detail.refresh();
  });
  useEffect(() => void detail.refresh(), [detail, vehicle.order_id, vehicle.visit_id]);
  const t = texts.value;
  const visits = detail.value.value?.visits.filter((visit) => visit.state !== "done") ?? [];
  if (detail.problem.value !== null) return <ProblemAlert problem={detail.problem.value} />;
  return (
    <div>
      <h3>{t.visits}</h3>
      {detail.value.value?.hold_ends != null && (
        <p class="hint">{t.held_until(formatTime(detail.value.value.hold_ends))}</p>
      )}
      {detail.value.value?.charged_at != null && (
        <p class="hint">{t.charged_at(formatTime(detail.value.value.charged_at))}</p>
      )}
      {detail.value.value?.order_waits === true && <p class="hint">{t.order_waits}</p>}
      {visits.length === 0 && <p class="hint">{t.no_visits}</p>}
      <ol class="visits">
        {visits.map((visit) => (
          <li key={visit.visit_id}>
            <span>
              {visit.stop_id === "" ? t.visit_kinds[visit.kind] : stopName(visit.stop_id)}
              <small>
                {[t.visit_states[visit.state], t.rest_reasons[visit.why]]
                  .filter((text) => text)
                  .join(" · ")}
              </small>
            </span>
            <span class="people">
              {visit.board.length > 0 && t.boards(visit.board.length)}{" "}
              {visit.alight.length > 0 && t.alights(visit.alight.length)}
            </span>
            <time>{visit.eta === null ? "" : formatTime(visit.eta)}</time>
          </li>
        ))}
      </ol>
    </div>
  );
}
