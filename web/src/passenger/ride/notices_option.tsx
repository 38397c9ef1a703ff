import { useMemo } from "preact/hooks";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import { RideNotices } from "./ride_notices";

/** Offers to tell the passenger of the ride while the page is closed. Nothing where the browser cannot. */
export function NoticesOption({ token }: { readonly token: string }) {
  const notices = useMemo(() => new RideNotices(token), [token]);
  const t = texts.value;
  const state = notices.state.value;
  if (state === "unavailable") return null;
  return (
    <div class="notices" data-notices={state}>
      {state === "on" ? (
        <>
          <Alert tone="good">{t.notices_on}</Alert>
          <button type="button" class="button small" onClick={() => void notices.stop()}>
            {t.notices_stop}
          </button>
        </>
      ) : state === "denied" ? (
        <p class="hint">{t.notices_denied}</p>
      ) : (
        <>
          <button
            type="button"
            class="button wide"
            disabled={state === "asking"}
            onClick={() => void notices.ask()}
          >
            {t.notices_ask}
          </button>
          <p class="hint">{t.notices_hint}</p>
        </>
      )}
      {state === "failed" && <Alert tone="warning">{t.notices_failed}</Alert>}
      {notices.problem.value !== null && <ProblemAlert problem={notices.problem.value} />}
    </div>
  );
}
