import type { Signal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import { CampusMap } from "../../shared/map/campus_map";
import { drawLine } from "../../shared/map/drawing/base_map";
import type { MapLayer, MapSelection } from "../../shared/map/map_content";
import type { Point } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { texts } from "../texts/texts";

const LINE_PX = 3;

interface AreaPickerProps {
  readonly campus: Campus;
  /** Corners in the map frame, m. */
  readonly outline: Signal<readonly Point[]>;
}

/** The area's corners, set by clicks on the map. */
export function AreaPicker({ campus, outline }: AreaPickerProps) {
  const t = texts.value;
  const { lanes } = campus.geometry;
  const focus = useMemo<readonly Point[]>(
    () => lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]),
    [lanes],
  );
  const corners = outline.value;
  const select = (selection: MapSelection) => {
    if (selection.kind === "ground") outline.value = [...outline.value, selection.at];
  };
  const layer: MapLayer = (context, camera, palette) => {
    if (corners.length > 0)
      drawLine(context, camera, [...corners, corners[0]!], palette.closed_road, LINE_PX);
  };
  return (
    <div class="road-picker">
      <p class="hint">{t.scan_area_hint}</p>
      <CampusMap
        geometry={campus.geometry}
        content={{
          scene: null,
          pickup: "",
          destination: "",
          selected_vehicle: "",
          closed_roads: [],
          language: language.value,
          interpolate: false,
          layer,
          selects_ground: true,
        }}
        focus={focus}
        focus_key={campus.geometry.map_version}
        attribution={campus.view.attribution}
        texts={{
          map: t.scan_area_map,
          zoom_in: t.zoom_in,
          zoom_out: t.zoom_out,
          show_all: t.whole_map,
        }}
        onSelect={select}
      />
      <p class="hint" role="status">
        {t.scan_corners(corners.length)}
      </p>
      {corners.length > 0 && (
        <button
          type="button"
          class="button small"
          onClick={() => (outline.value = corners.slice(0, -1))}
        >
          {t.scan_last_corner}
        </button>
      )}
    </div>
  );
}
