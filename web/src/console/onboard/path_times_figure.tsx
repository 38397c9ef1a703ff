import type { PathTimes } from "../../shared/scene/onboard_scene";
import { texts } from "../texts/texts";
import { scaleOf, trackShape, wayLine } from "./path_times_chart";

const WIDTH = 320;
const HEIGHT = 150;
/** For the numbers at the axes. */
const LEFT = 30;
const BELOW = 18;

/** The s-t graph: where tracks are on the path and when, the corridor between them, and the chosen motion. */
export function PathTimesFigure({ times }: { readonly times: PathTimes }) {
  const t = texts.value;
  const scale = scaleOf(times, WIDTH, HEIGHT);
  const { dt_s } = times;
  return (
    <figure class="chart st-graph">
      <figcaption>
        {t.st_graph}
        <span class="legend">
          <span>
            <i class="st-way" aria-hidden="true" /> {t.st_chosen}
          </span>
          <span>
            <i class="st-yielded" aria-hidden="true" /> {t.st_yielded}
          </span>
          <span>
            <i class="st-track" aria-hidden="true" /> {t.st_track}
          </span>
          <span>
            <i class="st-bound" aria-hidden="true" /> {t.st_corridor}
          </span>
        </span>
      </figcaption>
      <svg
        viewBox={`0 0 ${WIDTH + LEFT + 8} ${HEIGHT + BELOW + 8}`}
        role="img"
        aria-label={t.st_described(
          times.tracks?.length ?? 0,
          (times.way_m.at(-1) ?? 0).toFixed(1),
          scale.time_s.toFixed(0),
        )}
      >
        <g transform={`translate(${LEFT} 8)`}>
          <rect class="st-frame" width={WIDTH} height={HEIGHT} />
          {(times.tracks ?? []).map((track) => (
            <path
              key={track[0]}
              class={track[1] ? "st-yielded" : "st-track"}
              d={trackShape(track, dt_s, scale)}
            />
          ))}
          <path class="st-bound" d={wayLine(times.high_m, dt_s, scale)} />
          <path class="st-bound" d={wayLine(times.low_m, dt_s, scale)} />
          <path class="st-way" d={wayLine(times.way_m, dt_s, scale)} />
          <text x="-4" y="10" text-anchor="end">
            {scale.way_m.toFixed(0)} m
          </text>
          <text x="-4" y={HEIGHT} text-anchor="end">
            0
          </text>
          <text x={WIDTH} y={HEIGHT + 14} text-anchor="end">
            {scale.time_s.toFixed(0)} s
          </text>
        </g>
      </svg>
    </figure>
  );
}
