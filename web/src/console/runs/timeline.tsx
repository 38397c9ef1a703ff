import type { ComponentChildren } from "preact";
import { useId, useMemo } from "preact/hooks";
import { NextIcon, PauseIcon, PlayIcon, PreviousIcon } from "../../shared/ui/icons";
import { texts } from "../texts/texts";
import { formatTimeWithSeconds } from "../texts/times";
import { BUCKETS, type Mark, markedBuckets, nextMark } from "./marks";
import { type PlaybackClock, SPEED_FACTORS } from "./playback_clock";

interface TimelineProps {
  readonly clock: PlaybackClock;
  readonly start_ms: number;
  readonly end_ms: number;
  /** Oldest first. */
  readonly marks: readonly Mark[];
  readonly step_ms: number;
  /** A row of its own below the marks. */
  readonly row?: ComponentChildren;
  /** The operator has set the time. */
  readonly onSeek?: (at_ms: number) => void;
}

/** Play, speed and time of a replay, with what happened marked above the slider. */
export function Timeline(props: TimelineProps) {
  const { clock, start_ms, end_ms, marks, step_ms, row, onSeek } = props;
  const t = texts.value;
  const id = useId();
  const is_playing = clock.playing.value;
  const at_ms = clock.at_ms.value;
  const seek = (to_ms: number) => {
    clock.seek(to_ms);
    onSeek?.(clock.at_ms.value);
  };
  const jump = (direction: 1 | -1) => {
    const mark = nextMark(marks, at_ms, direction);
    if (mark !== undefined) seek(mark.at_ms);
  };
  return (
    <div class="timeline">
      <button
        type="button"
        class="button main"
        aria-label={is_playing ? t.pause : t.play}
        onClick={() => {
          clock.toggle();
          if (!clock.playing.value) onSeek?.(clock.at_ms.value);
        }}
      >
        {is_playing ? <PauseIcon /> : <PlayIcon />}
      </button>
      <button
        type="button"
        class="button quiet"
        aria-label={t.previous_mark}
        disabled={nextMark(marks, at_ms, -1) === undefined}
        onClick={() => jump(-1)}
      >
        <PreviousIcon />
      </button>
      <button
        type="button"
        class="button quiet"
        aria-label={t.next_mark}
        disabled={nextMark(marks, at_ms, 1) === undefined}
        onClick={() => jump(1)}
      >
        <NextIcon />
      </button>
      <time>{formatTimeWithSeconds(at_ms)}</time>
      <div class="timeline-track">
        <MarkRows marks={marks} start_ms={start_ms} end_ms={end_ms} />
        {row}
        <input
          type="range"
          aria-label={t.at_time}
          aria-valuetext={formatTimeWithSeconds(at_ms)}
          min={start_ms}
          max={end_ms}
          step={step_ms}
          value={at_ms}
          onInput={(event) => seek(event.currentTarget.valueAsNumber)}
        />
      </div>
      <time>{formatTimeWithSeconds(end_ms)}</time>
      <label class="visually-hidden" for={id}>
        {t.play_speed}
      </label>
      <select
        id={id}
        class="input"
        value={clock.speed_factor.value}
        onChange={(event) => {
          clock.speed_factor.value = Number(event.currentTarget.value);
        }}
      >
        {SPEED_FACTORS.map((factor) => (
          <option key={factor} value={factor}>
            {t.speed_factor(factor)}
          </option>
        ))}
      </select>
    </div>
  );
}

interface MarkRowsProps {
  readonly marks: readonly Mark[];
  readonly start_ms: number;
  readonly end_ms: number;
}

/** One line of short strokes for each kind of mark; the list beside the map names them. */
function MarkRows({ marks, start_ms, end_ms }: MarkRowsProps) {
  const paths = useMemo(
    () =>
      markedBuckets(marks, start_ms, end_ms).map((places, row) =>
        places.map((place) => `M${place} ${6 * row}v5`).join(""),
      ),
    [marks, start_ms, end_ms],
  );
  return (
    <svg
      class="mark-rows"
      viewBox={`-1 0 ${BUCKETS + 2} 17`}
      preserveAspectRatio="none"
      aria-hidden="true"
    >
      {paths.map((path, row) => (
        <path key={row} class={`mark-row-${row}`} d={path} vector-effect="non-scaling-stroke" />
      ))}
    </svg>
  );
}
