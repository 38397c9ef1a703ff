import { useEffect, useRef, useState } from "preact/hooks";
import type { CampusShape } from "../campus/campus_geometry";
import type { Point } from "../scene/scene";
import { AimIcon, FitIcon, MinusIcon, PlusIcon } from "../ui/icons";
import type { Look, Picked } from "./map_view";
import { MapView } from "./map_view";

export interface MapTexts {
  readonly map: string;
  readonly zoom_in: string;
  readonly zoom_out: string;
  readonly whole: string;
  readonly follow?: string;
}

interface CampusMapProps {
  readonly shape: CampusShape;
  readonly look: Look;
  readonly texts: MapTexts;
  /** What the camera shows when it is free; a new `focus_key` frees it and looks there at once. */
  readonly focus: readonly Point[];
  readonly focus_key: string;
  readonly attribution: string;
  readonly onPick: (what: Picked) => void;
  /** With a chosen shuttle: a button that keeps the camera with it. */
  readonly followable?: boolean;
}

const ZOOM_STEP = 1.6;

/** The campus on a canvas, with buttons for those who cannot or would rather not pinch. */
export function CampusMap(props: CampusMapProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const view = useRef<MapView | null>(null);
  const latest = useRef(props);
  const taken = useRef(false);
  const [follows, setFollows] = useState(false);
  latest.current = props;

  useEffect(() => {
    const made = new MapView(canvas.current!, {
      picked: (what) => latest.current.onPick(what),
      taken: () => {
        taken.current = true;
        setFollows(false);
      },
    });
    view.current = made;
    return () => made.leave();
  }, []);

  useEffect(() => view.current?.showCampus(props.shape), [props.shape]);
  useEffect(
    () => view.current?.show({ ...props.look, follow: follows && props.followable === true }),
    [props.look, follows, props.followable],
  );
  useEffect(() => {
    taken.current = false;
  }, [props.focus_key]);
  useEffect(() => {
    if (!taken.current) view.current?.fit(props.focus);
  }, [props.focus, props.focus_key]);

  const refit = () => {
    taken.current = false;
    setFollows(false);
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
        <button type="button" aria-label={texts.whole} title={texts.whole} onClick={refit}>
          <FitIcon />
        </button>
        {props.followable === true && texts.follow !== undefined && (
          <button
            type="button"
            aria-label={texts.follow}
            title={texts.follow}
            aria-pressed={follows}
            onClick={() => setFollows(!follows)}
          >
            <AimIcon />
          </button>
        )}
      </div>
      {props.attribution !== "" && <p class="map-credit">{props.attribution}</p>}
    </div>
  );
}
