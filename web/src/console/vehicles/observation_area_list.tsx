import type { AreaObservation } from "../../shared/scene/observation_areas";
import { areaObservations } from "../../shared/scene/observation_areas";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { areaName } from "../texts/names";
import { texts } from "../texts/texts";

interface ObservationAreaListProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  readonly now_ms: number;
}

/** The areas that this shuttle watches, each with its camera's report and the report's age. */
export function ObservationAreaList({ vehicle, scene, now_ms }: ObservationAreaListProps) {
  const own_area_ids = new Set(vehicle.status?.driving?.areas.map((area) => area.area_id));
  const shown = areaObservations(scene, now_ms).filter((area) => own_area_ids.has(area.area_id));
  if (shown.length === 0) return null;
  return (
    <div class="observation-areas">
      <h3>{texts.value.observation_areas}</h3>
      <ul>
        {shown.map((area) => (
          <li key={area.area_id} class={area.seen_by_vehicle ? "seen" : area.state}>
            <strong>{areaName(area.area_id)}</strong> {areaText(area)}
          </li>
        ))}
      </ul>
    </div>
  );
}

function areaText(area: AreaObservation): string {
  const t = texts.value;
  const report =
    area.camera_count === null || area.camera_age_ms === null
      ? t.area_no_camera
      : t.area_line(
          t.area_states[area.state],
          area.camera_count,
          (area.camera_age_ms / 1000).toFixed(1),
        );
  return area.seen_by_vehicle ? `${report} · ${t.area_seen_by_vehicle}` : report;
}
