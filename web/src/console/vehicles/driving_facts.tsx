import type { Scene, VehicleScene } from "../../shared/scene/scene";
import type { Watched } from "../../shared/scene/watched";
import { watchedAreas } from "../../shared/scene/watched";
import { words } from "../texts/words";

const SECTION = "section ";

export interface VehicleFactsProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  /** The server's clock at the scene, which in a replay is long ago. */
  readonly now_ms: number;
}

/** What keeps the shuttle from going faster, in words; a reason without words of ours is shown as it is. */
export function limitOf(vehicle: VehicleScene): string {
  const say = words.value;
  const reason = vehicle.picture?.limited_by ?? "";
  if (reason === "") return say.none;
  if (reason.startsWith(SECTION)) return `${say.section_ahead} (${reason.slice(SECTION.length)})`;
  return say.limits[reason] ?? reason;
}

/** The areas that this shuttle watches, each with its camera's word and how old that is. */
export function WatchedAreas({ vehicle, scene, now_ms }: VehicleFactsProps) {
  const mine = new Set(vehicle.picture?.areas.map((area) => area.area_id));
  const shown = watchedAreas(scene, now_ms).filter((area) => mine.has(area.area_id));
  if (shown.length === 0) return null;
  return (
    <div class="watched">
      <h3>{words.value.watched}</h3>
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
  const say = words.value;
  const word =
    area.told === null || area.age_ms === null
      ? say.area_no_word
      : say.area_line(say.area_states[area.state], area.told, (area.age_ms / 1000).toFixed(1));
  return area.seen ? `${word} · ${say.area_seen}` : word;
}
