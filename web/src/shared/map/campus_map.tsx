import { useEffect, useRef, useState } from "preact/hooks";
import type { CampusGeometry } from "../campus/campus_geometry";
import type { Point } from "../scene/scene";
import { FitIcon, FollowIcon, MinusIcon, PlusIcon } from "../ui/icons";
import type { MapContent, MapDrag, MapSelection } from "./map_content";
import { MapView } from "./map_view";

export interface MapTexts {
  readonly map: string;
  readonly zoom_in: string;
  readonly zoom_out: string;
  readonly show_all: string;
  readonly follow?: string;
}

interface CampusMapProps {
  readonly geometry: CampusGeometry;
  readonly content: MapContent;
  readonly texts: MapTexts;
  /** What the camera shows until the user moves it; a new `focus_key` moves it there again. */
  readonly focus: readonly Point[];
  readonly focus_key: string;
  readonly attribution: string;
  readonly onSelect: (selection: MapSelection) => void;
  /** What can be dragged; without it dragging moves the camera. */
  readonly drag?: MapDrag | null;
  /** Shows a button that makes the camera follow the selected shuttle. */
  readonly followable?: boolean;
}

const ZOOM_STEP = 1.6;

/** The campus on a canvas. Its buttons do what gestures do, for users who cannot pinch. */
export function CampusMap(props: CampusMapProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const view = useRef<MapView | null>(null);
  const latest = useRef(props);
  const camera_moved = useRef(false);
  const [is_following, setFollowing] = useState(false);
  latest.current = props;

  useEffect(() => {
    const created = new MapView(canvas.current!, {
      selected: (selection) => latest.current.onSelect(selection),
      drag: () => latest.current.drag ?? null,
      cameraMoved: () => {
        camera_moved.current = true;
        setFollowing(false);
      },
    });
    view.current = created;
    return () => created.close();
  }, []);

  useEffect(() => view.current?.setGeometry(props.geometry), [props.geometry]);
  useEffect(
    () =>
      view.current?.setContent({
        ...props.content,
        follow: is_following && props.followable === true,
      }),
    [props.content, is_following, props.followable],
  );
  useEffect(() => {
    camera_moved.current = false;
  }, [props.focus_key]);
  useEffect(() => {
    if (!camera_moved.current) view.current?.fit(props.focus);
  }, [props.focus, props.focus_key]);

  const showAll = () => {
    camera_moved.current = false;
    setFollowing(false);
    view.current?.fit(props.focus);
  };
  const { texts } = props;
  return (
    <div class="map">
      <canvas ref={canvas} tabIndex={0} role="application" aria-label={texts.map} />
      <div class="map-buttons">
        <button
          type="button"
          aria-label={texts.zoom_in}
          title={texts.zoom_in}
          onClick={() => view.current?.zoom(ZOOM_STEP)}
        >
          <PlusIcon />
        </button>
        <button
          type="button"
          aria-label={texts.zoom_out}
          title={texts.zoom_out}
          onClick={() => view.current?.zoom(1 / ZOOM_STEP)}
        >
          <MinusIcon />
        </button>
        <button type="button" aria-label={texts.show_all} title={texts.show_all} onClick={showAll}>
          <FitIcon />
        </button>
        {props.followable === true && texts.follow !== undefined && (
          <button
            type="button"
            aria-label={texts.follow}
            title={texts.follow}
            aria-pressed={is_following}
            onClick={() => setFollowing(!is_following)}
          >
            <FollowIcon />
          </button>
        )}
      </div>
      {props.attribution !== "" && <p class="map-credit">{props.attribution}</p>}
    </div>
  );
}
