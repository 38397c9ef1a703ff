import { useSignal } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import { campus } from "../../shared/campus/campus";
import { Loading, ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { EffectList } from "../interventions/effect_list";
import { link } from "../session";
import { Resource } from "../store/resource";
import { texts } from "../texts/texts";
import { onePerRoad } from "./road_picker";

interface ClosureDialogProps {
  readonly request: Schemas["ClosureBody"];
  readonly onClosed: (closure: Schemas["ClosureView"]) => void;
  readonly onClose: () => void;
}

/** Shows which rides end or come later before the operator confirms the closure. */
export function ClosureDialog({ request, onClosed, onClose }: ClosureDialogProps) {
  const t = texts.value;
  const is_sending = useSignal(false);
  const preview = useMemo(
    () => new Resource(() => resultOf(api.POST("/api/v1/closures/previews", { body: request }))),
    [request],
  );
  useEffect(() => void preview.refresh(), [preview]);
  const confirm = async () => {
    is_sending.value = true;
    const result = await resultOf(api.POST("/api/v1/closures", { body: request }));
    is_sending.value = false;
    if (result.ok) onClosed(result.value);
    else preview.problem.value = result.problem;
  };
  const effects = preview.value.value;
  const problem = preview.problem.value;
  const lanes = (campus.value?.geometry.lanes ?? []).filter((lane) =>
    request.lane_ids?.includes(lane.lane_id),
  );
  const vehicles = link.value?.scene.value?.vehicles ?? [];
  return (
    <Dialog title={t.close_road_title(onePerRoad(lanes).length)} onClose={onClose}>
      <p>{t.closures_lead}</p>
      <h3>{t.preview}</h3>
      {problem !== null && <ProblemAlert problem={problem} />}
      {effects === null && problem === null && <Loading text={t.loading} />}
      {effects !== null && <EffectList effects={effects} vehicles={vehicles} />}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cancel}
        </button>
        <button
          type="button"
          class="button main danger"
          disabled={effects === null || is_sending.value}
          onClick={() => void confirm()}
        >
          {t.close_road}
        </button>
      </div>
    </Dialog>
  );
}
