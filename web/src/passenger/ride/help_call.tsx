import { useSignal } from "@preact/signals";
import { useId } from "preact/hooks";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { formatTime } from "../../shared/texts/times";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { HelpIcon } from "../../shared/ui/icons";
import { texts } from "../texts/texts";
import type { RideTracker } from "./ride_tracker";

/** Calls the operators after one confirmation. */
export function HelpButton({ ride }: { readonly ride: RideTracker }) {
  const open = useSignal(false);
  return (
    <>
      <button
        type="button"
        class="button danger help"
        onClick={() => {
          open.value = true;
        }}
      >
        <HelpIcon />
        {texts.value.help}
      </button>
      {open.value && (
        <HelpDialog
          ride={ride}
          onClose={() => {
            open.value = false;
          }}
        />
      )}
    </>
  );
}

function HelpDialog({
  ride,
  onClose,
}: {
  readonly ride: RideTracker;
  readonly onClose: () => void;
}) {
  const text = useSignal("");
  const busy = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const id = useId();
  const t = texts.value;
  const call = async () => {
    busy.value = true;
    problem.value = await ride.callHelp(text.value);
    busy.value = false;
    if (problem.value === null) onClose();
  };
  return (
    <Dialog title={t.help_title} onClose={onClose}>
      <p>{t.help_text}</p>
      <div class="field">
        <label for={id}>{t.help_description}</label>
        <textarea
          id={id}
          class="input"
          maxLength={500}
          value={text.value}
          onInput={(event) => {
            text.value = event.currentTarget.value;
          }}
        />
      </div>
      <p class="hint">{t.help_emergency}</p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.help_no}
        </button>
        <button
          type="button"
          class="button main danger"
          autofocus
          disabled={busy.value}
          onClick={() => void call()}
        >
          {busy.value ? t.help_calling : ride.help_at.value === null ? t.help_yes : t.help_again}
        </button>
      </div>
    </Dialog>
  );
}

export function HelpReceipt({
  ride,
  timezone,
}: {
  readonly ride: RideTracker;
  readonly timezone: string;
}) {
  const at = ride.help_at.value;
  if (at === null) return null;
  return (
    <Alert tone="good">{texts.value.help_received(formatTime(at, language.value, timezone))}</Alert>
  );
}
