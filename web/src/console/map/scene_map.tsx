import { useMemo } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import type { Campus } from "../../shared/campus/campus";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { CampusMap } from "../../shared/map/campus_map";
import { drivingLayer } from "../../shared/map/driving_layer";
import type { MapContent, MapLayer } from "../../shared/map/map_content";
import { scanLayer } from "../../shared/map/scan_layer";
import { prefersReducedMotion } from "../../shared/map/reduced_motion";
import type { OnboardScene } from "../../shared/scene/onboard_scene";
import type { Point, Scene } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { closedLines } from "../closures/closed_lines";
import { pointsLayer, seenLayer } from "../onboard/seen_layer";
import { texts } from "../texts/texts";
import { drawChoice, type PositionChoice } from "../vehicles/position_choice";

type Closure = Schemas["ClosureView"];

interface SceneMapProps {
  readonly campus: Campus;
  readonly scene: Scene | null;
  readonly selected_vehicle: string;
  /** false: the scene is a jump in time, across which poses are not interpolated. */
  readonly interpolate: boolean;
  readonly closures?: readonly Closure[];
  /** The scene's clock now; by default the scene's own time. */
  readonly at_ms?: number | undefined;
  readonly geometry?: CampusGeometry;
  /** What one shuttle sees in detail. */
  readonly onboard?: OnboardScene | null;
  /** A recorded scan beside the map that the shuttle compared it with. */
  readonly scan?: Schemas["ScanMoment"] | null;
  /** A place that is being chosen: clicks then go to `onGround` and select no shuttle. */
  readonly choice?: PositionChoice | null;
  readonly onGround?: (at: Point) => void;
  readonly onSelect: (vehicle_id: string) => void;
}

/** A scene on the campus map, live or replayed. */
export function SceneMap({
  campus,
  scene,
  selected_vehicle,
  interpolate,
  closures = [],
  at_ms,
  geometry = campus.geometry,
  onboard = null,
  scan = null,
  choice = null,
  onGround,
  onSelect,
}: SceneMapProps) {
  const content: MapContent = {
    scene,
    pickup: "",
    destination: "",
    selected_vehicle,
    closed_roads: closedLines(closures),
    language: language.value,
    selects_ground: choice !== null,
    interpolate: interpolate && !prefersReducedMotion.value,
    ...(scene === null
      ? {}
      : {
          layer: sceneLayer(scene, at_ms ?? scene.at_ms, selected_vehicle, onboard, scan, choice),
        }),
  };
  const focus = useMemo<readonly Point[]>(
    () => geometry.lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]),
    [geometry],
  );
  return (
    <CampusMap
      geometry={geometry}
      content={content}
      focus={focus}
      focus_key={geometry.map_version}
      followable={selected_vehicle !== ""}
      attribution={campus.view.attribution}
      texts={{
        map: texts.value.map,
        zoom_in: texts.value.zoom_in,
        zoom_out: texts.value.zoom_out,
        show_all: texts.value.whole_map,
        follow: texts.value.follow,
      }}
      onSelect={(selection) => {
        if (selection.kind === "vehicle") onSelect(selection.id);
        if (selection.kind === "ground") onGround?.(selection.at);
      }}
    />
  );
}

/** What shuttles plan and see; points and cells lie below paths, and road users above. */
function sceneLayer(
  scene: Scene,
  at_ms: number,
  selected_vehicle: string,
  onboard: OnboardScene | null,
  scan: Schemas["ScanMoment"] | null,
  choice: PositionChoice | null,
): MapLayer {
  // A run of an older agent has the tracks of its status alone.
  const is_detailed = onboard !== null && (onboard.tracks_by ?? "") !== "";
  const driving = drivingLayer(scene, at_ms, selected_vehicle, is_detailed ? selected_vehicle : "");
  const points = onboard === null ? null : pointsLayer(onboard);
  const seen = onboard === null ? null : seenLayer(onboard);
  const scanned = scan === null ? null : scanLayer(scan);
  return (...drawing) => {
    scanned?.(...drawing);
    points?.(...drawing);
    driving(...drawing);
    seen?.(...drawing);
    const [context, camera, palette] = drawing;
    if (choice !== null) drawChoice(context, camera, palette, choice);
  };
}
