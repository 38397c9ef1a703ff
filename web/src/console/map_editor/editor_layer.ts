import { drawLine } from "../../shared/map/drawing/base_map";
import type { MapLayer } from "../../shared/map/map_content";
import type { Point } from "../../shared/scene/scene";
import type { Elements } from "./drawing";
import { poseAt } from "./drawing";
import type { Chosen, MapProblem } from "./editor_state";

const LANE_PX = 2;
const CHOSEN_PX = 6;
const DOT_PX = 6;
const STOP_LINE_PX = 3;
const ARROW_PX = 7;

interface Drawn {
  readonly elements: Elements;
  readonly chosen: Chosen | null;
  readonly problems: readonly MapProblem[];
  /** Places of a line that is being drawn. */
  readonly clicked: readonly Point[];
  readonly drive: readonly Point[];
  /** A stop is being dragged; the map shows where it was. */
  readonly is_dragging: boolean;
}

/** What only the editor draws: lines with their direction, stop lines, zones, kerbs, problems, the trial drive. */
export function editorLayer(drawn: Drawn): MapLayer {
  const { elements, chosen } = drawn;
  const lanes = new Map(elements.lanes.map((lane) => [lane.lane_id, lane.points]));
  return (context, camera, palette) => {
    const px = 1 / camera.px_per_m;
    const isChosen = (kind: Chosen["kind"], id: string) =>
      chosen?.kind === kind && chosen.id === id;
    const dot = ([x, y]: Point, colour: string, radius_px = DOT_PX) => {
      context.fillStyle = colour;
      context.beginPath();
      context.arc(x, y, radius_px * px, 0, 2 * Math.PI);
      context.fill();
    };
    const tick = (lane_id: string, s_m: number, colour: string) => {
      const points = lanes.get(lane_id);
      if (points === undefined) return;
      const { at, yaw_rad } = poseAt(points, s_m);
      const [dx, dy] = [-1.5 * Math.sin(yaw_rad), 1.5 * Math.cos(yaw_rad)];
      const ends: Point[] = [
        [at[0] + dx, at[1] + dy],
        [at[0] - dx, at[1] - dy],
      ];
      drawLine(context, camera, ends, colour, STOP_LINE_PX);
    };
    for (const lane of elements.lanes) {
      const is_chosen = isChosen("lanes", lane.lane_id);
      const colour = is_chosen ? palette.route : palette.path;
      drawLine(context, camera, lane.points, colour, is_chosen ? CHOSEN_PX : LANE_PX);
      if (is_chosen) arrow(context, lane.points, palette.ink, px);
    }
    for (const area of elements.observation_areas) {
      const is_chosen = isChosen("observation_areas", area.area_id);
      if (is_chosen)
        drawLine(context, camera, [...area.outline, area.outline[0]!], palette.route, LANE_PX);
      for (const [lane_id, s_m] of area.stop_lines)
        tick(lane_id, s_m, is_chosen ? palette.route : palette.ink);
    }
    for (const zone of elements.no_stopping_zones) {
      const points = lanes.get(zone.lane_id);
      if (points !== undefined)
        drawLine(
          context,
          camera,
          stretch(points, zone.s_from_m, zone.s_to_m),
          isChosen("no_stopping_zones", zone.zone_id) ? palette.route : palette.closed_road,
          CHOSEN_PX,
        );
    }
    for (const kerb of elements.kerbs)
      drawLine(
        context,
        camera,
        kerb.points,
        isChosen("kerbs", kerb.kerb_id) ? palette.route : palette.ink,
        STOP_LINE_PX,
      );
    for (const place of elements.resting_places) {
      const points = lanes.get(place.lane_id);
      if (points !== undefined) dot(poseAt(points, place.s_m).at, palette.vehicle.calm, DOT_PX - 2);
    }
    if (drawn.drive.length > 1) drawLine(context, camera, drawn.drive, palette.pickup, CHOSEN_PX);
    for (const problem of drawn.problems)
      if (problem.place !== null) dot(problem.place, palette.closed_road, DOT_PX + 2);
    const stop = elements.stops.find((one) => isChosen("stops", one.stop_id));
    const under = stop === undefined ? undefined : lanes.get(stop.lane_id);
    if (drawn.is_dragging && stop !== undefined && under !== undefined)
      dot(poseAt(under, stop.s_m).at, palette.route, DOT_PX + 2);
    if (drawn.clicked.length > 1)
      drawLine(context, camera, drawn.clicked, palette.route, STOP_LINE_PX);
    for (const place of drawn.clicked) dot(place, palette.route);
  };
}

/** Where one drives to. */
function arrow(
  context: CanvasRenderingContext2D,
  points: readonly Point[],
  colour: string,
  px: number,
): void {
  const end = points.at(-1);
  const before = points.at(-2);
  if (end === undefined || before === undefined) return;
  const yaw_rad = Math.atan2(end[1] - before[1], end[0] - before[0]);
  context.fillStyle = colour;
  context.beginPath();
  for (const [along, across] of [
    [1, 0],
    [-1, 0.8],
    [-1, -0.8],
  ] as const) {
    const [x, y] = [along * ARROW_PX * px, across * ARROW_PX * px];
    context.lineTo(
      end[0] + x * Math.cos(yaw_rad) - y * Math.sin(yaw_rad),
      end[1] + x * Math.sin(yaw_rad) + y * Math.cos(yaw_rad),
    );
  }
  context.fill();
}

function stretch(points: readonly Point[], from_m: number, to_m: number): Point[] {
  const inner: Point[] = [];
  let s_m = 0;
  points.forEach((point, index) => {
    if (index > 0)
      s_m += Math.hypot(point[0] - points[index - 1]![0], point[1] - points[index - 1]![1]);
    if (s_m > from_m && s_m < to_m) inner.push(point);
  });
  return [poseAt(points, from_m).at, ...inner, poseAt(points, to_m).at];
}
