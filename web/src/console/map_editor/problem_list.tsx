import type { Point } from "../../shared/scene/scene";
import { Alert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import type { Elements, Kind } from "./drawing";
import { KINDS, idOf } from "./drawing";
import type { EditorState, MapProblem } from "./editor_state";

interface ProblemListProps {
  readonly state: EditorState;
  readonly onShow: (place: Point) => void;
}

/** What keeps the draft from being published: each problem with its place, and a fix where there is one. */
export function ProblemList({ state, onShow }: ProblemListProps) {
  const t = texts.value;
  const found = state.found.value;
  const show = (problem: MapProblem) => {
    if (problem.place !== null) onShow([problem.place[0], problem.place[1]]);
    const kind = kindOf(state.elements.peek(), problem.where);
    if (kind !== null) state.chosen.value = { kind, id: problem.where };
  };
  return (
    <section class="block card" aria-busy={state.checking.value}>
      <h2>{t.map_problems}</h2>
      {found === null ? (
        <p class="hint" role="status">
          {t.checking_map}
        </p>
      ) : found.count === 0 ? (
        <Alert tone="good">{t.map_is_sound(found.resting_places)}</Alert>
      ) : (
        <p role="status">{t.problems_left(found.count)}</p>
      )}
      <ul class="rows problem-rows">
        {(found?.problems ?? []).map((problem) => (
          <li key={`${problem.defect} ${problem.where} ${problem.detail}`}>
            <div class="line">
              <span>
                <strong>{t.map_problem_names[problem.defect] ?? problem.defect}</strong>
                <small>
                  {problem.where}: {problem.detail}
                </small>
              </span>
              <span class="buttons">
                {problem.place !== null && (
                  <button type="button" class="button small" onClick={() => show(problem)}>
                    {t.show_place}
                  </button>
                )}
                {problem.can_be_mended && (
                  <button
                    type="button"
                    class="button small main"
                    disabled={state.saving.value}
                    onClick={() => void state.mend(problem)}
                  >
                    {t.mend}
                  </button>
                )}
              </span>
            </div>
          </li>
        ))}
      </ul>
    </section>
  );
}

function kindOf(elements: Elements, id: string): Kind | null {
  return KINDS.find((kind) => elements[kind].some((one) => idOf(one) === id)) ?? null;
}
