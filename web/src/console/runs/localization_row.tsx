import { useMemo } from "preact/hooks";
import type { Scene } from "../../shared/scene/scene";
import { texts } from "../texts/texts";
import { bandColumns, PHASES, phaseShares } from "./localization_band";
import { BUCKETS } from "./marks";

const HEIGHT = 10;

interface LocalizationRowProps {
  readonly scenes: readonly Scene[];
  readonly start_ms: number;
  readonly end_ms: number;
}

/** Below the marks: how well the shuttle knew where it was; the higher, the greater the deviation. */
export function LocalizationRow({ scenes, start_ms, end_ms }: LocalizationRowProps) {
  const t = texts.value;
  const columns = useMemo(() => bandColumns(scenes, start_ms, end_ms), [scenes, start_ms, end_ms]);
  const shares = useMemo(() => phaseShares(scenes), [scenes]);
  if (columns.length === 0) return null;
  const said = shares.map(({ phase, share }) =>
    t.share_of_run(t.localization_phases[phase], Math.max(1, Math.round(100 * share))),
  );
  return (
    <svg
      class="localization-row"
      viewBox={`0 0 ${BUCKETS} ${HEIGHT}`}
      preserveAspectRatio="none"
      role="img"
      aria-label={`${t.localization}: ${said.join("; ")}`}
    >
      <title>{said.join("\n")}</title>
      {PHASES.map((phase) => (
        <path
          key={phase}
          class={`phase-${phase}`}
          d={columns
            .filter((column) => column.phase === phase)
            .map(
              ({ place, height }) =>
                `M${place} ${HEIGHT}v${-HEIGHT * height}h1v${HEIGHT * height}z`,
            )
            .join("")}
        />
      ))}
    </svg>
  );
}
