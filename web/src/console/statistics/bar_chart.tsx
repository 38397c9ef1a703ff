export interface Bar {
  readonly label: string;
  /** Parts of the bar from the bottom up, in the order of `kinds`. */
  readonly parts: readonly number[];
}

interface BarChartProps {
  /** What is shown, for people who do not see it; the table below says the numbers. */
  readonly title: string;
  readonly bars: readonly Bar[];
  /** The names of the parts; a single one needs no legend. */
  readonly kinds: readonly string[];
}

const HEIGHT = 160;
/** Where the highest bar ends; its number is above. */
const HIGHEST_Y = 14;
const SLOT = 24;
const GAP = 4;

/** Stacked bars. Every number is also in a table. */
export function BarChart({ title, bars, kinds }: BarChartProps) {
  const highest = Math.max(1, ...bars.map((bar) => sum(bar.parts)));
  return (
    <figure class="chart">
      <figcaption>
        {title}
        {kinds.length > 1 && (
          <span class="legend">
            {kinds.map((kind, k) => (
              <span key={kind}>
                <i class={`part-${k}`} aria-hidden="true" /> {kind}
              </span>
            ))}
          </span>
        )}
      </figcaption>
      <svg
        viewBox={`0 0 ${SLOT * bars.length} ${HEIGHT + 20}`}
        role="img"
        aria-label={title}
        style={{ maxWidth: `${2 * SLOT * bars.length}px` }}
      >
        {bars.map((bar, k) => (
          <g key={bar.label} transform={`translate(${SLOT * k} 0)`}>
            {heights(bar.parts, highest).map(([y, height], part) => (
              <rect
                key={part}
                class={`part-${part}`}
                x={GAP / 2}
                y={y}
                width={SLOT - GAP}
                height={height}
              />
            ))}
            {(bars.length <= 16 || k % 3 === 0) && (
              <text x={SLOT / 2} y={HEIGHT + 14} text-anchor="middle">
                {bar.label}
              </text>
            )}
          </g>
        ))}
        <text x={GAP / 2} y={HIGHEST_Y - 3}>
          {highest}
        </text>
        <line x1="0" x2={SLOT * bars.length} y1={HIGHEST_Y} y2={HIGHEST_Y} class="faint" />
        <line x1="0" x2={SLOT * bars.length} y1={HEIGHT} y2={HEIGHT} />
      </svg>
    </figure>
  );
}

/** Top and height of each part. */
function heights(
  parts: readonly number[],
  highest: number,
): readonly (readonly [number, number])[] {
  let top = HEIGHT;
  return parts.map((part) => {
    const height = ((HEIGHT - HIGHEST_Y) * part) / highest;
    top -= height;
    return [top, height] as const;
  });
}

function sum(values: readonly number[]): number {
  return values.reduce((total, value) => total + value, 0);
}
