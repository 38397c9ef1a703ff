import type { Signal } from "@preact/signals";
import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import { CampusMap } from "../../shared/map/campus_map";
import { drawLine } from "../../shared/map/drawing/base_map";
import type { MapLayer, MapSelection } from "../../shared/map/map_content";
import type { Point } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { closures } from "../store/closures";
import { texts } from "../texts/texts";
import { closedLines } from "./closed_lines";
import type { Lane } from "./roads";
import { length_m, oppositeLanes, roadAt, roadName } from "./roads";

const CHOSEN_PX = 7;

interface RoadPickerProps {
  readonly campus: Campus;
  /** Ids of the chosen lanes. */
  readonly chosen: Signal<readonly string[]>;
}

/** The roads to be closed, chosen by clicks on the map and listed by name. */
export function RoadPicker({ campus, chosen }: RoadPickerProps) {
  const t = texts.value;
  const both_directions = useSignal(true);
  const missed = useSignal(false);
  const { lanes, stops } = campus.geometry;
  const shown = lanes.filter((lane) => chosen.value.includes(lane.lane_id));
  const focus = useMemo<readonly Point[]>(
    () => lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]),
    [lanes],
  );
  const together = (lane: Lane) =>
    both_directions.value ? [lane, ...oppositeLanes(lanes, lane)] : [lane];
  const take_out = (lane: Lane) => {
    const gone = new Set(together(lane).map((each) => each.lane_id));
    chosen.value = chosen.value.filter((lane_id) => !gone.has(lane_id));
  };
  const select = (selection: MapSelection) => {
    if (selection.kind !== "ground") return;
    const lane = roadAt(lanes, selection.at, selection.reach_m);
    missed.value = lane === null;
    if (lane === null) return;
    if (chosen.value.includes(lane.lane_id)) take_out(lane);
    else
      chosen.value = [...new Set([...chosen.value, ...together(lane).map((each) => each.lane_id)])];
  };
  const layer: MapLayer = (context, camera, palette) => {
    for (const lane of shown)
      drawLine(context, camera, lane.points, palette.closed_road, CHOSEN_PX);
  };
  return (
    <div class="road-picker">
      <p class="hint">{t.closure_map_hint}</p>
      <CampusMap
        geometry={campus.geometry}
        content={{
          scene: null,
          pickup: "",
          destination: "",
          selected_vehicle: "",
          closed_roads: closedLines(closures.value.value ?? []),
          language: language.value,
          interpolate: false,
          layer,
          selects_ground: true,
        }}
        focus={focus}
        focus_key={campus.geometry.map_version}
        attribution={campus.view.attribution}
        texts={{
          map: t.closure_map,
          zoom_in: t.zoom_in,
          zoom_out: t.zoom_out,
          show_all: t.whole_map,
        }}
        onSelect={select}
      />
      <label class="check">
        <input
          type="checkbox"
          checked={both_directions.value}
          onChange={(event) => {
            both_directions.value = event.currentTarget.checked;
          }}
        />
        {t.closure_both_directions}
      </label>
      <ul class="chosen-roads" aria-live="polite">
        {onePerRoad(shown, both_directions.value).map((lane) => {
          const name = roadName(lane, stops, language.value, t.road_near);
          return (
            <li key={lane.lane_id} class="chip warning">
              {t.road(name, Math.round(length_m(lane)))}
              <button type="button" aria-label={t.remove_road(name)} onClick={() => take_out(lane)}>
                ×
              </button>
            </li>
          );
        })}
      </ul>
      {shown.length === 0 && (
        <p class="hint" role="status">
          {missed.value ? t.no_road_there : t.no_roads_chosen}
        </p>
      )}
    </div>
  );
}

/** Each road once, where both of its directions are meant. */
export function onePerRoad(lanes: readonly Lane[], both_directions = true): readonly Lane[] {
  if (!both_directions) return lanes;
  const shown: Lane[] = [];
  for (const lane of lanes)
    if (!shown.some((other) => oppositeLanes([lane], other).length > 0)) shown.push(lane);
  return shown;
}
