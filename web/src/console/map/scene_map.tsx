import { useMemo } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import type { Campus } from "../../shared/campus/campus";
import type { CampusShape } from "../../shared/campus/campus_geometry";
import { pairs } from "../../shared/campus/campus_geometry";
import { CampusMap } from "../../shared/map/campus_map";
import type { Look } from "../../shared/map/map_view";
import { prefersStill } from "../../shared/map/reduced_motion";
import type { Point, Scene } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { texts } from "../texts/texts";
import { drivingLayer } from "./driving_layer";

type Closure = Schemas["ClosureView"];

interface SceneMapProps {
  readonly campus: Campus;
  readonly scene: Scene | null;
  readonly chosen: string;
  readonly still: boolean;
  readonly closures?: readonly Closure[];
  /** The scene's clock now; without it, the scene's own moment. */
  readonly at_ms?: number | undefined;
  readonly shape?: CampusShape;
  readonly onChoose: (vehicle_id: string) => void;
}

/** A scene on the campus map; it does not know whether the scene is live or replayed. */
export function SceneMap({
  campus,
  scene,
  chosen,
  still,
  closures = [],
  at_ms,
  shape = campus.shape,
  onChoose,
}: SceneMapProps) {
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
    ...(scene === null ? {} : { layer: drivingLayer(scene, at_ms ?? scene.at_ms, chosen) }),
  };
  const focus = useMemo<readonly Point[]>(
    () => shape.lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]),
    [shape],
  );
  return (
    <CampusMap
      shape={shape}
      look={look}
      focus={focus}
      focus_key={shape.map_version}
      followable={chosen !== ""}
      attribution={campus.view.attribution}
      texts={{
        map: texts.value.map,
        zoom_in: texts.value.zoom_in,
        zoom_out: texts.value.zoom_out,
        whole: texts.value.whole_map,
        follow: texts.value.follow,
      }}
      onPick={(what) => {
        if (what.kind === "vehicle") onChoose(what.id);
      }}
    />
  );
}
