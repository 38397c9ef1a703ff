import { monotonic_ms } from "../../shared/live/clock";
import { Alert } from "../../shared/ui/alerts";
import { OLD_MS, type RequestedWatch, type Shown } from "../onboard/requested_watch";
import { withNames } from "../texts/names";
import { texts } from "../texts/texts";

interface RequestStateProps<S extends Shown> {
  readonly watch: RequestedWatch<S>;
  readonly connected: boolean;
}

/** How old it is, or why nothing comes. */
export function RequestState<S extends Shown>({ watch, connected }: RequestStateProps<S>) {
  const t = texts.value;
  // The age grows with the time of this screen.
  void monotonic_ms.value;
  const { value: shown } = watch.shown;
  if (shown === null) return null;
  const { age_ms } = watch;
  const age_s = age_ms === null ? "" : (age_ms / 1000).toFixed(1);
  const is_old = age_ms !== null && age_ms > OLD_MS;
  return (
    <>
      {!connected && <Alert>{t.scene_out_of_reach}</Alert>}
      {connected && shown.request === "failed" && (
        <Alert>{t.scene_refused(withNames(shown.detail))}</Alert>
      )}
      {connected && shown.request === "pending" && <p class="hint">{t.scene_asked}</p>}
      {!watch.watching.value && <p class="hint">{t.scene_over}</p>}
      {age_ms !== null &&
        (is_old ? (
          <Alert tone="warning">{t.scene_is_old(age_s)}</Alert>
        ) : (
          <p class="hint">{t.scene_age(age_s)}</p>
        ))}
    </>
  );
}
