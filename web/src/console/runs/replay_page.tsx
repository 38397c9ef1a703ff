import { useEffect, useId, useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import type { Knowledge } from "../../shared/state/knowledge";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { BackIcon, PauseIcon, PlayIcon } from "../../shared/ui/icons";
import { SceneMap } from "../map/scene_map";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { formatDateTime, formatTimeWithSeconds } from "../texts/times";
import { ConditionChip } from "../vehicles/condition_chip";
import { VehicleStatus } from "../vehicles/vehicle_status";
import { RunPlayer } from "./run_player";

const SPEED_FACTORS = [1, 2, 5, 10, 30];

interface ReplayPageProps {
  readonly campus: Campus;
  readonly vehicle_id: string;
  readonly boot_id: string;
}

export function ReplayPage({ campus, vehicle_id, boot_id }: ReplayPageProps) {
  const player = useMemo(() => new RunPlayer(vehicle_id, boot_id), [vehicle_id, boot_id]);
  useEffect(() => () => player.close(), [player]);
  const t = texts.value;
  const scene = player.scene.value;
  const vehicle = scene?.vehicles[0];
  return (
    <div class="live replay">
      <div class="replay-stage">
        <SceneMap
          campus={campus}
          {...(player.geometry.value === null ? {} : { geometry: player.geometry.value })}
          scene={scene}
          selected_vehicle={vehicle_id}
          interpolate={!player.is_seek.value}
          onSelect={() => undefined}
        />
        {scene !== null && <Timeline player={player} />}
      </div>
      <aside class="side">
        <section class="block vehicle">
          <header class="block-head">
            <button type="button" class="button quiet small" onClick={() => goTo("runs")}>
              <BackIcon />
              {t.back_to_runs}
            </button>
          </header>
          <div class="row-head">
            <h1>{vehicle?.facts.name ?? vehicle_id}</h1>
            {vehicle !== undefined && scene !== null && (
              <ConditionChip vehicle={vehicle} knowledge={asKnownAt(scene.at_ms)} />
            )}
          </div>
          <p class="hint">
            {t.replay_banner}
            {scene !== null && ` · ${formatDateTime(player.start_ms)}`}
          </p>
          <RunLoadState player={player} />
          {player.map_problem.value !== null && <Alert>{t.run_map_missing}</Alert>}
          {scene !== null && vehicle !== undefined && (
            <VehicleStatus vehicle={vehicle} scene={scene} knowledge={asKnownAt(scene.at_ms)} />
          )}
        </section>
      </aside>
    </div>
  );
}

/** A recorded scene is what was known at its time. */
function asKnownAt(at_ms: number): Knowledge {
  return { now_ms: at_ms, known_ms: at_ms };
}

function RunLoadState({ player }: { readonly player: RunPlayer }) {
  const t = texts.value;
  const count = player.scenes.value.length;
  if (player.problem.value !== null) return <ProblemAlert problem={player.problem.value} />;
  if (player.loading.value) return <Loading text={t.loading_run(count)} />;
  return count === 0 ? <Alert>{t.empty_run}</Alert> : null;
}

function Timeline({ player }: { readonly player: RunPlayer }) {
  const t = texts.value;
  const id = useId();
  const is_playing = player.playing.value;
  return (
    <div class="timeline">
      <button
        type="button"
        class="button main"
        aria-label={is_playing ? t.pause : t.play}
        onClick={() => player.toggle()}
      >
        {is_playing ? <PauseIcon /> : <PlayIcon />}
      </button>
      <time>{formatTimeWithSeconds(player.at_ms.value)}</time>
      <input
        type="range"
        aria-label={t.at_time}
        aria-valuetext={formatTimeWithSeconds(player.at_ms.value)}
        min={player.start_ms}
        max={player.end_ms}
        step={200}
        value={player.at_ms.value}
        onInput={(event) => player.seek(event.currentTarget.valueAsNumber)}
      />
      <time>{formatTimeWithSeconds(player.end_ms)}</time>
      <label class="visually-hidden" for={id}>
        {t.play_speed}
      </label>
      <select
        id={id}
        class="input"
        value={player.speed_factor.value}
        onChange={(event) => {
          player.speed_factor.value = Number(event.currentTarget.value);
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
