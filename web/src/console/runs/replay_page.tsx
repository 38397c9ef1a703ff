import { useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import type { Knowledge } from "../../shared/state/knowledge";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { fragmentOf } from "../address";
import { SceneMap } from "../map/scene_map";
import { OnboardView } from "../onboard/onboard_view";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { ConditionChip } from "../vehicles/condition_chip";
import { VehicleStatus } from "../vehicles/vehicle_status";
import { CopyLink } from "./copy_link";
import { LocalizationRow } from "./localization_row";
import { MarkList } from "./mark_list";
import { RunFiles } from "./run_files";
import { RunPlayer } from "./run_player";
import { ScanBlock } from "./scan_block";
import { Timeline } from "./timeline";
import { VideoBlock } from "./video_block";

const STEP_MS = 200;

interface ReplayPageProps {
  readonly campus: Campus;
  readonly vehicle_id: string;
  readonly boot_id: string;
  /** Where to begin; null for the beginning of the run. */
  readonly first_ms: number | null;
}

export function ReplayPage({ campus, vehicle_id, boot_id, first_ms }: ReplayPageProps) {
  const player = useMemo(() => new RunPlayer(vehicle_id, boot_id, first_ms), [vehicle_id, boot_id]);
  useEffect(() => () => player.close(), [player]);
  // Another link to the same run was opened.
  useEffect(() => player.show(first_ms), [player, first_ms]);
  const { clock } = player;
  const linkTo = (at_ms: number) =>
    fragmentOf("runs", vehicle_id, boot_id, String(Math.round(at_ms)));
  // While time stands, the address is a link to this moment.
  useSignalEffect(() => {
    if (player.scenes.value.length === 0 || clock.playing.value || player.is_on_the_way) return;
    history.replaceState(null, "", linkTo(clock.at_ms.value));
  });
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
          onboard={player.onboard.value ?? null}
          scan={player.scan.value ?? null}
          selected_vehicle={vehicle_id}
          interpolate={!clock.is_seek.value}
          onSelect={() => undefined}
        />
        {scene !== null && (
          <Timeline
            clock={clock}
            start_ms={player.start_ms}
            end_ms={player.end_ms}
            marks={player.marks.value}
            step_ms={STEP_MS}
            row={
              <LocalizationRow
                scenes={player.scenes.value}
                start_ms={player.start_ms}
                end_ms={player.end_ms}
              />
            }
          />
        )}
      </div>
      <aside class="side">
        <section class="block vehicle">
          <header class="block-head">
            <button type="button" class="button quiet small" onClick={() => goTo("runs")}>
              <BackIcon />
              {t.back_to_runs}
            </button>
            {scene !== null && <CopyLink href={linkTo(clock.at_ms.value)} />}
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
        {scene !== null && <OnboardBlock player={player} />}
        {scene !== null && <VideoBlock player={player} />}
        {scene !== null && <ScanBlock player={player} />}
        {scene !== null && <MarkList marks={player.marks.value} clock={clock} />}
        <RunFiles vehicle_id={vehicle_id} boot_id={boot_id} />
      </aside>
    </div>
  );
}

/** What the shuttle saw and planned at this moment. */
function OnboardBlock({ player }: { readonly player: RunPlayer }) {
  const t = texts.value;
  const onboard = player.onboard.value;
  return (
    <section class="block" aria-label={t.onboard}>
      <h2>{t.onboard}</h2>
      {player.pieces.problem.value !== null && (
        <ProblemAlert problem={player.pieces.problem.value} />
      )}
      {onboard === undefined && <p class="empty">{t.onboard_loading}</p>}
      {onboard === null && <p class="empty">{t.onboard_missing}</p>}
      {onboard != null && <OnboardView scene={onboard} />}
    </section>
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
