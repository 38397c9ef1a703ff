import { useEffect, useRef } from "preact/hooks";
import { ProblemAlert } from "../../shared/ui/alerts";
import { may } from "../session";
import { texts } from "../texts/texts";
import type { PlaybackClock } from "./playback_clock";
import type { RunPlayer } from "./run_player";
import { following } from "./run_video";

/** The video of the vehicle's cameras at the replay's moment, for operators with the role for it. */
export function VideoBlock({ player }: { readonly player: RunPlayer }) {
  const t = texts.value;
  const { video, clock } = player;
  if (!may("dispatcher", "safety")) return null;
  const none = !video.loading.value && video.problem.value === null && video.cameras.length === 0;
  return (
    <section class="block" aria-label={t.run_video}>
      <h2>{t.run_video}</h2>
      {!video.shown.value && (
        <button
          type="button"
          class="button small"
          onClick={() => void video.show(player.start_ms, player.end_ms)}
        >
          {t.show_video}
        </button>
      )}
      {video.problem.value !== null && <ProblemAlert problem={video.problem.value} />}
      {video.shown.value && none && <p class="empty">{t.video_missing}</p>}
      <div class="run-video">
        {video.cameras.map((camera) => {
          const found = video.at(camera, clock.at_ms.value);
          return (
            <figure key={camera}>
              {found === null ? (
                <p class="empty">{t.video_missing_now}</p>
              ) : (
                <CameraVideo sha256={found.segment.sha256} at_s={found.at_s} clock={clock} />
              )}
              <figcaption>{camera}</figcaption>
            </figure>
          );
        })}
      </div>
    </section>
  );
}

interface CameraVideoProps {
  readonly sha256: string;
  readonly at_s: number;
  readonly clock: PlaybackClock;
}

/** One element for all segments of a camera: the next one is loaded into it. */
function CameraVideo({ sha256, at_s, clock }: CameraVideoProps) {
  const element = useRef<HTMLVideoElement>(null);
  const playing = clock.playing.value;
  const speed_factor = clock.speed_factor.value;
  useEffect(() => {
    const video = element.current;
    if (video === null) return;
    const { seek_s, play, rate } = following(video, at_s, playing, speed_factor);
    video.playbackRate = rate;
    if (seek_s !== null && !video.seeking) video.currentTime = seek_s;
    // A browser may refuse to play; the picture then follows by seeking.
    if (play && video.paused) video.play().catch(() => undefined);
    if (!play && !video.paused) video.pause();
  }, [sha256, at_s, playing, speed_factor]);
  return (
    <video
      ref={element}
      src={`/api/v1/video-segments/${sha256}`}
      muted
      playsInline
      preload="auto"
    />
  );
}
