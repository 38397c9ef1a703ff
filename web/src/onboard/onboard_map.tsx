import { useEffect, useMemo, useState } from "preact/hooks";
import type { CampusGeometry } from "../shared/campus/campus_geometry";
import { campusGeometry } from "../shared/campus/campus_geometry";
import { CampusMap } from "../shared/map/campus_map";
import { drivingLayer } from "../shared/map/driving_layer";
import type { MapContent } from "../shared/map/map_content";
import { prefersReducedMotion } from "../shared/map/reduced_motion";
import type { Point } from "../shared/scene/scene";
import { language } from "../shared/texts/language";
import type { CabinView } from "./screen_scene";
import { mapScene } from "./screen_scene";
import { texts } from "./texts/texts";

/** Shown around the shuttle: what it sees and plans lies within this. */
const AROUND_M = 30;

type Loaded = { readonly geometry: CampusGeometry; readonly attribution: string };

interface OnboardMapProps {
  readonly vehicle_id: string;
  readonly view: CabinView | null;
  readonly url: string;
  readonly onStops: (stops: CampusGeometry["stops"]) => void;
}

/** The campus around the shuttle, with its planned way and the people it sees. */
export function OnboardMap({ vehicle_id, view, url, onStops }: OnboardMapProps) {
  const t = texts.value;
  const [loaded, setLoaded] = useState<Loaded | null>(null);
  const [failed, setFailed] = useState(false);
  useEffect(() => {
    fetch(url)
      .then((response) => response.json())
      .then((map) => {
        const geometry = campusGeometry(map);
        setLoaded({ geometry, attribution: map.attribution });
        onStops(geometry.stops);
      })
      .catch((error: unknown) => {
        console.error("the map could not be loaded", error);
        setFailed(true);
      });
  }, [url]);
  const scene = useMemo(() => mapScene(vehicle_id, view), [vehicle_id, view]);
  const focus = useMemo<readonly Point[]>(() => focusOf(scene, loaded?.geometry), [scene, loaded]);
  if (loaded === null) return <p class="map">{failed ? t.no_map : ""}</p>;
  const content: MapContent = {
    scene,
    pickup: "",
    destination: view?.visits[0]?.stop_id ?? "",
    selected_vehicle: vehicle_id,
    language: language.value,
    interpolate: !prefersReducedMotion.value,
    ...(scene === null ? {} : { layer: drivingLayer(scene, scene.at_ms, vehicle_id) }),
  };
  return (
    <div class="map-frame">
      <CampusMap
        geometry={loaded.geometry}
        content={content}
        focus={focus}
        focus_key={loaded.geometry.map_version}
        attribution={loaded.attribution}
        texts={{
          map: t.map,
          zoom_in: t.zoom_in,
          zoom_out: t.zoom_out,
          show_all: t.show_all,
        }}
        onSelect={() => undefined}
      />
      {scene === null && <p class="no-position">{t.no_position}</p>}
    </div>
  );
}

function focusOf(
  scene: ReturnType<typeof mapScene>,
  geometry: CampusGeometry | undefined,
): readonly Point[] {
  const pose = scene?.vehicles[0]?.status?.pose_map;
  if (pose === undefined)
    return geometry?.lanes.flatMap((lane) => [lane.points[0]!, lane.points.at(-1)!]) ?? [];
  const [x, y] = pose;
  return [
    [x - AROUND_M, y - AROUND_M],
    [x + AROUND_M, y + AROUND_M],
  ];
}
