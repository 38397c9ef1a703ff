import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import { Note, ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import { texts } from "../texts/texts";
import { forgetRide } from "../token_storage";
import type { Story } from "./ride_progress";
import type { FollowedRide } from "./ride_tracker";

interface RideActionsProps {
  readonly ride: FollowedRide;
  readonly story: Story;
  readonly onRedirect: () => void;
}

export function RideActions({ ride, story, onRedirect }: RideActionsProps) {
  const problem = useSignal<Problem | null>(null);
  const asking = useSignal(false);
  const t = texts.value;
  const run = (work: Promise<Problem | null>) =>
    void work.then((failed) => {
      problem.value = failed;
    });
  return (
    <div class="actions">
      {story.can_cancel && story.chapter !== "looking" && (
        <TapButton
          label={t.on_board}
          hint={t.tap_wait_here}
          enabled={story.can_tap_aboard}
          ride={ride}
          onTap={() => run(ride.tapAboard())}
        />
      )}
      {(story.chapter === "riding" || story.chapter === "arrived") && (
        <TapButton
          label={t.off_board}
          hint={t.tap_wait_there}
          enabled={story.can_tap_off}
          ride={ride}
          onTap={() => run(ride.tapOff())}
        />
      )}
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      <div class="minor">
        {story.can_redirect && (
          <button type="button" class="button" onClick={onRedirect}>
            {t.change_destination}
          </button>
        )}
        {(story.can_cancel || story.can_get_off) && (
          <button
            type="button"
            class="button danger"
            onClick={() => {
              asking.value = true;
            }}
          >
            {story.can_get_off ? t.get_off : t.cancel}
          </button>
        )}
        <CopyLink />
      </div>
      {asking.value && (
        <Question
          danger
          title={story.can_get_off ? t.get_off_title : t.cancel_title}
          text={story.can_get_off ? t.get_off_text : t.cancel_text}
          yes={story.can_get_off ? t.get_off : t.cancel_yes}
          no={t.cancel_no}
          onNo={() => {
            asking.value = false;
          }}
          onYes={() => {
            asking.value = false;
            if (!story.can_get_off) forgetRide(ride.token);
            run(ride.cancel());
          }}
        />
      )}
    </div>
  );
}

interface TapButtonProps {
  readonly label: string;
  readonly hint: string;
  readonly enabled: boolean;
  readonly ride: FollowedRide;
  readonly onTap: () => void;
}

function TapButton({ label, hint, enabled, ride, onTap }: TapButtonProps) {
  const t = texts.value;
  const tap = ride.tap.value;
  return (
    <div class="tap">
      <button
        type="button"
        class="button main large wide"
        disabled={!enabled || tap === "asked"}
        onClick={onTap}
      >
        {tap === "asked" ? t.tap_asked : label}
      </button>
      {!enabled && <p class="hint">{hint}</p>}
      {tap === "refused" && <Note tone="warning">{t.tap_refused}</Note>}
      {tap === "unanswered" && <Note tone="warning">{t.tap_unanswered}</Note>}
    </div>
  );
}

/** Browsers give the clipboard to secure origins only; elsewhere the link is in the address bar. */
function CopyLink() {
  const copied = useSignal(false);
  if (!window.isSecureContext) return null;
  const copy = async () => {
    await navigator.clipboard.writeText(location.href);
    copied.value = true;
  };
  return (
    <button
      type="button"
      class="button"
      title={texts.value.link_is_secret}
      onClick={() => void copy()}
    >
      {copied.value ? texts.value.link_copied : texts.value.copy_link}
    </button>
  );
}
