import { useSignal } from "@preact/signals";
import type { Problem } from "../../shared/api/problem";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { texts } from "../texts/texts";
import { canVibrate, setVibration, vibrates } from "./arrival_signs";
import { NoticesOption } from "./notices_option";
import type { RideProgress } from "./ride_progress";
import type { RideTracker } from "./ride_tracker";

interface RideActionsProps {
  readonly ride: RideTracker;
  readonly progress: RideProgress;
  readonly onChangeDestination: () => void;
}

export function RideActions({ ride, progress, onChangeDestination }: RideActionsProps) {
  const problem = useSignal<Problem | null>(null);
  const confirming = useSignal(false);
  const t = texts.value;
  const run = (action: Promise<Problem | null>) =>
    void action.then((outcome) => {
      problem.value = outcome;
    });
  return (
    <div class="actions">
      {progress.can_cancel && progress.phase !== "searching" && progress.phase !== "booked" && (
        <TapButton
          label={t.tap_on_board}
          hint={t.tap_hint_pickup}
          enabled={progress.can_tap_aboard}
          ride={ride}
          onTap={() => run(ride.tapAboard())}
        />
      )}
      {(progress.phase === "aboard" || progress.phase === "at_destination") && (
        <TapButton
          label={t.tap_off}
          hint={t.tap_hint_destination}
          enabled={progress.can_tap_off}
          ride={ride}
          onTap={() => run(ride.tapOff())}
        />
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {ride.pending_cancel.is_waiting.value && <WaitingCancel ride={ride} />}
      {ride.pending_cancel.refusal.value !== null && (
        <RefusedCancel problem={ride.pending_cancel.refusal.value} />
      )}
      <div class="secondary-actions">
        {progress.can_change_destination && (
          <button type="button" class="button" onClick={onChangeDestination}>
            {t.change_destination}
          </button>
        )}
        {(progress.can_get_off ||
          (progress.can_cancel && !ride.pending_cancel.is_waiting.value)) && (
          <button
            type="button"
            class="button danger"
            onClick={() => {
              confirming.value = true;
            }}
          >
            {progress.can_get_off ? t.get_off : t.cancel}
          </button>
        )}
        <CopyLinkButton />
      </div>
      {canVibrate && <VibrationOption />}
      {progress.can_cancel && <NoticesOption token={ride.token} />}
      {confirming.value && (
        <ConfirmDialog
          danger
          title={progress.can_get_off ? t.get_off_title : t.cancel_title}
          text={progress.can_get_off ? t.get_off_text : t.cancel_text}
          yes={progress.can_get_off ? t.get_off : t.cancel_yes}
          no={t.cancel_no}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => {
            confirming.value = false;
            run(progress.can_get_off ? ride.getOff() : ride.pending_cancel.ask());
          }}
        />
      )}
    </div>
  );
}

function VibrationOption() {
  return (
    <label class="walk-option">
      <input
        type="checkbox"
        checked={vibrates.value}
        onChange={(event) => setVibration(event.currentTarget.checked)}
      />
      {texts.value.vibrate}
    </label>
  );
}

function WaitingCancel({ ride }: { readonly ride: RideTracker }) {
  const t = texts.value;
  return (
    <div class="alert warning" role="status">
      <p>{t.cancel_waits}</p>
      <button type="button" class="button small" onClick={() => ride.pending_cancel.withdraw()}>
        {t.cancel_no}
      </button>
    </div>
  );
}

function RefusedCancel({ problem }: { readonly problem: Problem }) {
  return (
    <>
      <Alert tone="warning">{texts.value.cancel_came_too_late}</Alert>
      <ProblemAlert problem={problem} />
    </>
  );
}

interface TapButtonProps {
  readonly label: string;
  readonly hint: string;
  readonly enabled: boolean;
  readonly ride: RideTracker;
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
        disabled={!enabled || tap === "pending"}
        onClick={onTap}
      >
        {tap === "pending" ? t.tap_pending : label}
      </button>
      {!enabled && <p class="hint">{hint}</p>}
      {tap === "refused" && <Alert tone="warning">{t.tap_refused}</Alert>}
      {tap === "timed_out" && <Alert tone="warning">{t.tap_timed_out}</Alert>}
    </div>
  );
}

/** Browsers offer the clipboard to secure origins only; elsewhere the address bar shows the link. */
function CopyLinkButton() {
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
