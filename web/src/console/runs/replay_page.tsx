import { useEffect, useId, useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { BackIcon, PauseIcon, PlayIcon } from "../../shared/ui/icons";
import { SceneMap } from "../map/scene_map";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { day, seconds } from "../texts/times";
import { ConditionChip } from "../vehicles/condition_chip";
import { VehicleFacts } from "../vehicles/vehicle_panel";
import { Player } from "./run_player";

const FACTORS = [1, 2, 5, 10, 30];

interface ReplayPageProps {
  readonly campus: Campus;
  readonly vehicle_id: string;
  readonly boot_id: string;
}

export function ReplayPage({ campus, vehicle_id, boot_id }: ReplayPageProps) {
  const player = useMemo(() => new Player(vehicle_id, boot_id), [vehicle_id, boot_id]);
  useEffect(() => () => player.leave(), [player]);
  const t = texts.value;
  const scene = player.scene.value;
  const vehicle = scene?.vehicles[0];
  return (
    <div class="live replay">
      <div class="replay-stage">
        <SceneMap
          campus={campus}
          {...(player.shape.value === null ? {} : { shape: player.shape.value })}
          scene={scene}
          chosen={vehicle_id}
          still={player.jumped.value}
          onChoose={() => undefined}
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
            <h2>{vehicle?.name ?? vehicle_id}</h2>
            {vehicle !== undefined && <ConditionChip vehicle={vehicle} />}
          </div>
          <p class="hint">
            {t.replay_banner}
            {scene !== null && ` · ${day(player.start_ms)}`}
          </p>
          <RunState player={player} />
          {player.map_problem.value !== null && <Note>{t.run_map_gone}</Note>}
          {scene !== null && vehicle !== undefined && (
            <VehicleFacts vehicle={vehicle} scene={scene} now_ms={scene.at_ms} />
          )}
        </section>
      </aside>
    </div>
  );
}

function RunState({ player }: { readonly player: Player }) {
  const t = texts.value;
  const count = player.scenes.value.length;
  if (player.problem.value !== null) return <ProblemNote problem={player.problem.value} />;
  if (player.loading.value) return <Loading text={t.loading_run(count)} />;
  return count === 0 ? <Note>{t.empty_run}</Note> : null;
}

function Timeline({ player }: { readonly player: Player }) {
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
      <time>{seconds(player.at_ms.value)}</time>
      <input
        type="range"
        aria-label={t.at_time}
        aria-valuetext={seconds(player.at_ms.value)}
        min={player.start_ms}
        max={player.end_ms}
        step={200}
        value={player.at_ms.value}
        onInput={(event) => player.seek(event.currentTarget.valueAsNumber)}
      />
      <time>{seconds(player.end_ms)}</time>
      <label class="unseen" for={id}>
        {t.play_speed}
      </label>
      <select
        id={id}
        class="input"
        value={player.factor.value}
        onChange={(event) => {
          player.factor.value = Number(event.currentTarget.value);
        }}
      >
        {FACTORS.map((factor) => (
          <option key={factor} value={factor}>
            {t.times(factor)}
          </option>
        ))}
      </select>
    </div>
  );
}
