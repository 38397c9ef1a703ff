import { ProblemAlert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import type { RunPlayer } from "./run_player";
import { scanShares } from "./run_scans";

/** A button that lays the moment's scan over the map, and what its colours mean. */
export function ScanBlock({ player }: { readonly player: RunPlayer }) {
  const t = texts.value;
  const { scans } = player;
  const is_shown = scans.shown.value;
  const scan = player.scan.value;
  return (
    <section class="block" aria-label={t.scan_on_map}>
      <h2>{t.scan_on_map}</h2>
      <button
        type="button"
        class="button small"
        aria-pressed={is_shown}
        onClick={() => {
          scans.shown.value = !is_shown;
        }}
      >
        {is_shown ? t.hide_scan : t.show_scan}
      </button>
      {scans.problem.value !== null && <ProblemAlert problem={scans.problem.value} />}
      {is_shown && scan === undefined && scans.problem.value === null && (
        <p class="empty">{t.scan_loading}</p>
      )}
      {is_shown && scan === null && <p class="empty">{t.scan_missing}</p>}
      {scan != null && (
        <ul class="scan-legend">
          {(["agrees", "new", "through"] as const).map((kind) => (
            <li key={kind}>
              <i class={`scan-${kind}`} aria-hidden="true" />
              {t.share_of_run(t.scan_points[kind], scanShares(scan)[kind])}
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}
