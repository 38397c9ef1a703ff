import { texts } from "../texts/texts";
import { SelectField } from "../forms/select_field";
import type { Lane, Stop } from "./drawing";
import { lengthOf_m, round, withElement, withoutElement } from "./drawing";
import type { EditorState } from "./editor_state";
import { ValueField } from "./value_field";

const KMH = 3.6;
const SCENARIOS = ["common_road", "parking_lot", "unprotected_intersection"] as const;

/** The chosen element's values. Each is taken when its field is left. */
export function ElementForm({ state }: { readonly state: EditorState }) {
  const t = texts.value;
  const chosen = state.chosen.value;
  if (chosen === null) return <p class="hint">{t.choose_element}</p>;
  const elements = state.elements.value;
  const lane =
    chosen.kind === "lanes" ? elements.lanes.find((one) => one.lane_id === chosen.id) : undefined;
  const stop =
    chosen.kind === "stops" ? elements.stops.find((one) => one.stop_id === chosen.id) : undefined;
  const remove = () => {
    state.chosen.value = null;
    state.draw(withoutElement(elements, chosen.kind, chosen.id));
  };
  return (
    <section class="block card element-form">
      <h2>
        {t.element_kinds[chosen.kind]} <small>{chosen.id}</small>
      </h2>
      {lane !== undefined && <LaneFields key={lane.lane_id} state={state} lane={lane} />}
      {stop !== undefined && <StopFields key={stop.stop_id} state={state} stop={stop} />}
      <button type="button" class="button small danger" onClick={remove}>
        {t.delete_element}
      </button>
    </section>
  );
}

function LaneFields({ state, lane }: { readonly state: EditorState; readonly lane: Lane }) {
  const t = texts.value;
  const put = (changes: Partial<Lane>) =>
    state.draw(withElement(state.elements.peek(), "lanes", { ...lane, ...changes }));
  return (
    <>
      <p class="hint">{t.lane_length(Math.round(lengthOf_m(lane.points)))}</p>
      <ValueField label={t.element_name} value={lane.name ?? ""} onTake={(name) => put({ name })} />
      <ValueField
        label={t.element_name_en}
        value={lane.name_en ?? ""}
        onTake={(name_en) => put({ name_en })}
      />
      <ValueField
        label={t.speed_limit_kmh}
        value={String(round(lane.speed_limit_mps * KMH, 1))}
        number={{ min: 1, max: 60 }}
        onTake={(text) => put({ speed_limit_mps: Number(text) / KMH })}
      />
      <ValueField
        label={t.road_width_m}
        value={String(lane.width_m)}
        number={{ min: 2.4, max: 20 }}
        onTake={(text) => put({ width_m: Number(text) })}
      />
      <SelectField
        label={t.scenario_tag}
        value={lane.scenario ?? "common_road"}
        options={SCENARIOS.map((each) => [each, t.scenarios[each]])}
        onChange={(value) => put({ scenario: value as Lane["scenario"] & string })}
      />
    </>
  );
}

function StopFields({ state, stop }: { readonly state: EditorState; readonly stop: Stop }) {
  const t = texts.value;
  const put = (changes: Partial<Stop>) =>
    state.draw(withElement(state.elements.peek(), "stops", { ...stop, ...changes }));
  return (
    <>
      <ValueField label={t.element_name} value={stop.name} onTake={(name) => put({ name })} />
      <ValueField
        label={t.element_name_en}
        value={stop.name_en ?? ""}
        onTake={(name_en) => put({ name_en })}
      />
    </>
  );
}
