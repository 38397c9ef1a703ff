import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useMemo } from "preact/hooks";
import type { Campus } from "../../../shared/campus/campus";
import type { Scene } from "../../../shared/scene/scene";
import { Alert, Loading, ProblemAlert } from "../../../shared/ui/alerts";
import { BackIcon } from "../../../shared/ui/icons";
import { fragmentOf } from "../../address";
import { SceneMap } from "../../map/scene_map";
import { FailedLoad } from "../../failed_load";
import { goTo } from "../../navigation";
import { texts } from "../../texts/texts";
import { formatDateTime } from "../../texts/times";
import { Timeline } from "../timeline";
import { MarkList } from "../mark_list";
import { CopyLink } from "../copy_link";
import { ForkPanel } from "./fork_panel";
import { FleetPlayer } from "./fleet_player";
import { PastFleet } from "./past_fleet";
import { PastVehiclePanel } from "./past_vehicle_panel";
import { type FleetReplay, idsOfFleetReplay } from "./replay_address";

const STEP_MS = 1_000;

interface FleetReplayPageProps {
  readonly campus: Campus;
  readonly replay: FleetReplay;
}

/** The whole fleet on one line of time. */
export function FleetReplayPage({ campus, replay }: FleetReplayPageProps) {
  const { start_ms, end_ms } = replay;
  const { map_version } = campus.geometry;
  const player = useMemo(
    () => new FleetPlayer(start_ms, end_ms, replay.at_ms, map_version),
    [start_ms, end_ms, map_version],
  );
  useEffect(() => () => player.close(), [player]);
  // Another link to the same day was opened.
  useEffect(() => player.clock.seek(replay.at_ms), [player, replay.at_ms]);
  const selected = useSignal(replay.vehicle_id);
  const linkTo = (at_ms: number) =>
    fragmentOf(
      "runs",
      ...idsOfFleetReplay({ start_ms, end_ms, at_ms, vehicle_id: selected.value }),
    );
  // While time stands, the address is a link to this second.
  useSignalEffect(() => {
    if (player.clock.playing.value) return;
    history.replaceState(null, "", linkTo(player.clock.at_ms.value));
  });
  const t = texts.value;
  const scene = player.scene.value;
  const marks = player.past.value?.marks ?? [];
  const shown_marks = useMemo(
    () =>
      selected.value === ""
        ? marks
        : marks.filter((mark) => mark.vehicle_id === selected.value || mark.vehicle_id === ""),
    [marks, selected.value],
  );
  return (
    <div class="live replay">
      <div class="replay-stage">
        <SceneMap
          campus={campus}
          scene={scene}
          selected_vehicle={selected.value}
          interpolate={false}
          onSelect={(vehicle_id) => {
            selected.value = vehicle_id;
          }}
        />
        <Timeline
          clock={player.clock}
          start_ms={start_ms}
          end_ms={end_ms}
          marks={shown_marks}
          step_ms={STEP_MS}
        />
      </div>
      <aside class="side">
        <section class="block">
          <header class="block-head">
            <button type="button" class="button quiet small" onClick={() => goTo("runs")}>
              <BackIcon />
              {t.back_to_runs}
            </button>
            <CopyLink href={linkTo(player.clock.at_ms.value)} />
          </header>
          <h1>{t.fleet_replay}</h1>
          <p class="hint">
            {t.replay_banner} · {formatDateTime(player.clock.at_ms.value)}
          </p>
          <LoadState player={player} scene={scene} />
        </section>
        {scene !== null && selected.value !== "" && (
          <PastVehiclePanel
            player={player}
            scene={scene}
            vehicle_id={selected.value}
            onClose={() => {
              selected.value = "";
            }}
          />
        )}
        {scene !== null && selected.value === "" && (
          <PastFleet
            scene={scene}
            onSelect={(vehicle_id) => {
              selected.value = vehicle_id;
            }}
          />
        )}
        <MarkList marks={shown_marks} clock={player.clock} />
        <ForkPanel clock={player.clock} end_ms={end_ms} />
      </aside>
    </div>
  );
}

function LoadState({
  player,
  scene,
}: {
  readonly player: FleetPlayer;
  readonly scene: Scene | null;
}) {
  const t = texts.value;
  const { value: past_problem } = player.past_problem;
  if (past_problem !== null) {
    return <FailedLoad problem={past_problem} onRetry={() => void player.loadPast()} />;
  }
  // Pieces of positions are asked for again by themselves.
  const { value: piece_problem } = player.pieces.problem;
  if (piece_problem !== null) return <ProblemAlert problem={piece_problem} />;
  if (scene === null) return <Loading text={t.loading} />;
  if (player.tracks.value === null) return <Loading text={t.loading_positions} />;
  if (player.past.value?.is_cut === true) return <Alert>{t.replay_is_cut}</Alert>;
  if (player.tracks.value.length === 0) return <Alert>{t.no_positions_then}</Alert>;
  return null;
}
