import { useMemo } from "preact/hooks";
import type { Campus } from "../shared/api/campus";
import type { Schemas } from "../shared/api/client";
import { CampusMap } from "../shared/map/campus_map";
import { pairs } from "../shared/map/campus_shape";
import type { Look } from "../shared/map/map_view";
import { prefersStill } from "../shared/map/stillness";
import type { Point, Scene } from "../shared/scene/scene";
import { language } from "../shared/words/language";
import { words } from "./words";

type Closure = Schemas["ClosureView"];

interface SceneMapProps {
  readonly campus: Campus;
  readonly scene: Scene | null;
  readonly chosen: string;
  readonly still: boolean;
  readonly closures?: readonly Closure[];
  readonly onChoose: (vehicle_id: string) => void;
}

/** A scene on the campus map; it does not know whether the scene is live or replayed. */
export function SceneMap({ campus, scene, chosen, still, closures = [], onChoose }: SceneMapProps) {
  const look: Look = {
    scene,
    pickup: "",
    destination: "",
    chosen_vehicle: chosen,
    closed: closures
      .filter((closure) => closure.state === "in_force")
      .flatMap((closure) => closure.lines.map(pairs)),
    language: language.value,
    still: still || prefersStill.value,
  };
  const focus = useMemo<readonly Point[]>(
    () => campus.shape.lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]),
    [campus],
  );
  return (
    <CampusMap
      shape={campus.shape}
      look={look}
      focus={focus}
      focus_key={campus.shape.map_version}
      attribution={campus.view.attribution}
      words={{
        map: words.value.map,
        zoom_in: words.value.zoom_in,
        zoom_out: words.value.zoom_out,
        whole: words.value.whole_map,
      }}
      onPick={(what) => {
        if (what.kind === "vehicle") onChoose(what.id);
      }}
    />
  );
}
