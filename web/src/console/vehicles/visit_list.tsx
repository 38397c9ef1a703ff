import type { VehicleScene } from "../../shared/scene/scene";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTime, formatTimeOrDateTime } from "../texts/times";

/** The visits of the shuttle's plan that are not done. */
export function VisitList({ vehicle }: { readonly vehicle: VehicleScene }) {
  const t = texts.value;
  const { visits, hold_ends_ms, charged_at_ms, order_waits } = vehicle.task;
  return (
    <div>
      <h3>{t.visits}</h3>
      {hold_ends_ms > 0 && <p class="hint">{t.held_until(formatTime(hold_ends_ms))}</p>}
      {charged_at_ms > 0 && <p class="hint">{t.charged_at(formatTime(charged_at_ms))}</p>}
      {order_waits && <p class="hint">{t.order_waits}</p>}
      {visits.length === 0 && <p class="hint">{t.no_visits}</p>}
      <ol class="visits">
        {visits.map((visit) => (
          <li key={visit.visit_id}>
            <span>
              {visit.stop_id === "" ? t.visit_kinds[visit.kind] : stopName(visit.stop_id)}
              <small>
                {[t.visit_states[visit.state], visit.why === "" ? "" : t.rest_reasons[visit.why]]
                  .filter((text) => text)
                  .join(" · ")}
              </small>
            </span>
            <span class="people">
              {visit.boarding > 0 && t.boards(visit.boarding)}{" "}
              {visit.alighting > 0 && t.alights(visit.alighting)}
            </span>
            <time>{visit.eta_ms === 0 ? "" : formatTimeOrDateTime(visit.eta_ms)}</time>
          </li>
        ))}
      </ol>
    </div>
  );
}
