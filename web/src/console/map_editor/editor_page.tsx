import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import type { CampusGeometry } from "../../shared/campus/campus_geometry";
import { CampusMap } from "../../shared/map/campus_map";
import type { MapSelection } from "../../shared/map/map_content";
import type { Point } from "../../shared/scene/scene";
import { language } from "../../shared/texts/language";
import { Loading } from "../../shared/ui/alerts";
import { fragmentOf } from "../address";
import { texts } from "../texts/texts";
import { ElementDrag } from "./dragging";
import { ConflictNotice } from "./conflict_notice";
import type { Elements } from "./drawing";
import { poseAt } from "./drawing";
import { editorLayer } from "./editor_layer";
import { EditorState } from "./editor_state";
import { ElementForm } from "./element_form";
import { MapProblemAlert } from "./map_problem_alert";
import { ProblemList } from "./problem_list";
import { PublishPanel } from "./publish_panel";
import { ToolBar } from "./tool_bar";
import type { Tool } from "./tools";
import { tapped } from "./tools";
import { TrialDrive } from "./trial_drive";

interface EditorPageProps {
  readonly campus: Campus;
  readonly draft_id: string;
}

/** A draft on the map: what a tap does is chosen by the tool. Enter taps the centre, so all works by keyboard. */
export function EditorPage({ campus, draft_id }: EditorPageProps) {
  const t = texts.value;
  const state = useMemo(() => new EditorState(draft_id), [draft_id]);
  const drag = useMemo(() => new ElementDrag(state), [state]);
  const tool = useSignal<Tool>("select");
  const clicked = useSignal<readonly Point[]>([]);
  const drive = useSignal<readonly Point[]>([]);
  const goal = useSignal<Point | null>(null);
  useEffect(() => void state.load(), [state]);
  const elements = state.elements.value;
  const buildings = state.buildings.value;
  const geometry = useMemo(
    () => geometryOf(elements, buildings, `${draft_id}`),
    [elements, buildings, draft_id],
  );
  const whole = useMemo<readonly Point[]>(
    () =>
      geometry.lanes.flatMap((lane) => {
        const [first, last] = [lane.points[0], lane.points.at(-1)];
        return first === undefined || last === undefined ? [] : [first, last];
      }),
    [state.buildings.value],
  );
  const focus = useMemo(
    () => (goal.value === null ? whole : around(goal.value)),
    [goal.value, whole],
  );
  if (state.draft.value === null)
    return (
      <section class="sheet narrow">
        {state.problem.value === null ? (
          <Loading text={t.loading} />
        ) : (
          <MapProblemAlert problem={state.problem.value} />
        )}
        <a href={fragmentOf("maps")}>{t.all_maps}</a>
      </section>
    );
  const select = (selection: MapSelection) => {
    if (selection.kind !== "ground") return;
    tapped(state, tool.value, clicked, selection.at, selection.reach_m, t.new_stop);
  };
  return (
    <section class="map-editor">
      <div class="map-side">
        <header>
          <a href={fragmentOf("maps")}>{t.all_maps}</a>
          <h1>{state.draft.value.name}</h1>
          <p class="hint" role="status">
            {state.saving.value
              ? t.saving_draft
              : state.conflict.value
                ? t.draft_not_saved
                : t.draft_saved(state.draft.value.revision)}
          </p>
        </header>
        {state.conflict.value && <ConflictNotice state={state} />}
        {state.problem.value !== null && !state.conflict.value && (
          <MapProblemAlert problem={state.problem.value} />
        )}
        <ProblemList
          state={state}
          onShow={(place) => {
            goal.value = place;
          }}
        />
        <ElementForm state={state} />
        <TrialDrive state={state} line={drive} />
        <PublishPanel state={state} />
      </div>
      <div class="map-stage">
        <ToolBar state={state} tool={tool} clicked={clicked} />
        <CampusMap
          geometry={geometry}
          content={{
            scene: null,
            pickup: "",
            destination: "",
            selected_vehicle: "",
            language: language.value,
            interpolate: false,
            layer: editorLayer({
              elements: state.preview.value ?? elements,
              chosen: state.chosen.value,
              problems: state.found.value?.problems ?? [],
              clicked: clicked.value,
              drive: drive.value,
              is_dragging: state.preview.value !== null,
            }),
            selects_ground: true,
          }}
          focus={focus}
          focus_key={goal.value === null ? draft_id : `${draft_id} ${goal.value.join()}`}
          attribution={campus.view.attribution}
          texts={{
            map: t.editor_map,
            zoom_in: t.zoom_in,
            zoom_out: t.zoom_out,
            show_all: t.whole_map,
          }}
          drag={tool.value === "move" ? drag : null}
          onSelect={select}
        />
      </div>
    </section>
  );
}

/** What the map draws of any campus, made of the drawing. */
function geometryOf(
  elements: Elements,
  buildings: readonly (readonly Point[])[],
  map_version: string,
): CampusGeometry {
  const lanes = new Map(elements.lanes.map((lane) => [lane.lane_id, lane.points]));
  return {
    map_version,
    lanes: elements.lanes,
    buildings,
    stops: elements.stops.flatMap((stop) => {
      const points = lanes.get(stop.lane_id);
      if (points === undefined) return [];
      const [x_m, y_m] = poseAt(points, stop.s_m).at;
      return [{ ...stop, x_m, y_m, name_en: stop.name_en ?? "", placed_by: stop.placed_by ?? "" }];
    }),
    areas: new Map(elements.observation_areas.map((area) => [area.area_id, area.outline])),
  };
}

const AROUND_M = 40;

function around([x, y]: Point): readonly Point[] {
  return [
    [x - AROUND_M, y - AROUND_M],
    [x + AROUND_M, y + AROUND_M],
  ];
}
