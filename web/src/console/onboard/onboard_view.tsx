import type { OnboardScene } from "../../shared/scene/onboard_scene";
import { texts } from "../texts/texts";
import { PathTimesFigure } from "./path_times_figure";
import { SeenList } from "./seen_list";
import { TickTimesFigure } from "./tick_times_figure";

/** Limits that are told: those on the way that the plan covers. */
const LIMITS_SHOWN = 6;

/** What the shuttle sees and plans at one moment, as numbers, lists and graphs; the map has the places. */
export function OnboardView({ scene }: { readonly scene: OnboardScene }) {
  const t = texts.value;
  const { limited_by = null, path_times = null, tick_times = null } = scene;
  const points = (scene.points?.length ?? 0) / 2;
  const intervention =
    scene.guard === undefined || scene.guard === ""
      ? t.none
      : (t.guard_acts[scene.guard] ?? scene.guard);
  return (
    <>
      <dl class="facts">
        <div>
          <dt>{t.limited_by}</dt>
          <dd>{limited_by === null ? t.none : t.limits[limited_by]}</dd>
        </div>
        <div>
          <dt>{t.planned_speed}</dt>
          <dd>{t.kmh((3.6 * (scene.speed_mps_planned ?? 0)).toFixed(1))}</dd>
        </div>
        <div>
          <dt>{t.lidar_cells}</dt>
          <dd>
            {points === 0 ? t.none : t.cells_of_scan(points, (scene.points_age_s ?? 0).toFixed(1))}
          </dd>
        </div>
        <div>
          <dt>{t.guard}</dt>
          <dd>{intervention}</dd>
        </div>
      </dl>
      <SeenList scene={scene} />
      {path_times === null ? (
        <p class="empty">{t.no_st_graph}</p>
      ) : (
        <>
          <PathTimesFigure times={path_times} />
          <h3>{t.limits_ahead}</h3>
          <ul class="plain limits-ahead">
            {(path_times.limits ?? [])
              .slice(0, LIMITS_SHOWN)
              .map(([from_m, to_m, speed_mps, reason]) => (
                <li key={from_m}>
                  {t.limit_on(from_m.toFixed(0), to_m.toFixed(0))}{" "}
                  <strong>{t.kmh((3.6 * speed_mps).toFixed(0))}</strong> · {t.limits[reason]}
                </li>
              ))}
          </ul>
        </>
      )}
      {tick_times === null ? (
        <p class="empty">{t.no_tick_times}</p>
      ) : (
        <TickTimesFigure times={tick_times} />
      )}
    </>
  );
}
