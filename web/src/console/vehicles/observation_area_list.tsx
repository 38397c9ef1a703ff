import type { Watched } from "../../shared/scene/observation_areas";
import { watchedAreas } from "../../shared/scene/observation_areas";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { texts } from "../texts/texts";

const SECTION = "section ";

export interface VehicleFactsProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  /** The server's clock at the scene, which in a replay is long ago. */
  readonly now_ms: number;
}

/** What limits the shuttle's speed, as text; an unknown reason is shown as it is. */
export function limitOf(vehicle: VehicleScene): string {
  const t = texts.value;
  const reason = vehicle.picture?.limited_by ?? "";
  if (reason === "") return t.none;
  if (reason.startsWith(SECTION)) return `${t.section_ahead} (${reason.slice(SECTION.length)})`;
  return t.limits[reason] ?? reason;
}

/** The areas that this shuttle watches, each with its camera's report and the report's age. */
export function WatchedAreas({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const mine = new Set(vehicle.picture?.areas.map((area) => area.area_id));
  const shown = watchedAreas(scene, now_ms).filter((area) => mine.has(area.area_id));
  if (shown.length === 0) return null;
  return (
    <div class="watched">
      <h3>{texts.value.watched}</h3>
      <ul>
        {shown.map((area) => (
          <li key={area.area_id} class={area.seen ? "seen" : area.state}>
            <strong>{area.area_id}</strong> {lineOf(area)}
          </li>
        ))}
      </ul>
    </div>
  );
}

function lineOf(area: Watched): string {
  const t = texts.value;
  const report =
    area.told === null || area.age_ms === null
      ? t.area_no_camera
      : t.area_line(t.area_states[area.state], area.told, (area.age_ms / 1000).toFixed(1));
  return area.seen ? `${report} · ${t.area_seen}` : report;
}
