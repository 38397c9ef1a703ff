import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { Problem, Result } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { removeSeriesToken } from "../token_storage";
import type { SeriesTicket } from "./series_card";
import { SeriesCard } from "./series_card";
import { SeriesDays } from "./series_days";

const REFRESH_MS = 20_000;

interface SeriesPanelProps {
  readonly token: string;
  readonly campus: Campus;
}

/** One recurring booking, with the state of each of its days. */
export function SeriesPanel({ token, campus }: SeriesPanelProps) {
  const ticket = useSignal<SeriesTicket | null>(null);
  const problem = useSignal<Problem | null>(null);
  const accept = (result: Result<SeriesTicket>) => {
    if (result.ok) {
      ticket.value = result.value;
      if (result.value.state !== "active") removeSeriesToken(token);
    }
    problem.value = result.ok ? null : result.problem;
  };
  useEffect(() => {
    const load = async () => {
      const path = { token };
      accept(await resultOf(api.GET("/api/v1/series/{token}", { params: { path } })));
    };
    void load();
    const timer = window.setInterval(() => void load(), REFRESH_MS);
    return () => window.clearInterval(timer);
  }, [token]);
  const t = texts.value;
  const shown = ticket.value;
  return (
    <section class="ride">
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {shown === null ? (
        problem.value === null && <Loading text={t.series_loading} />
      ) : (
        <>
          <h1>{t.series_title}</h1>
          {shown.state !== "active" && <Alert>{t.series_states[shown.state]}</Alert>}
          <SeriesCard ticket={shown} campus={campus} />
          <SeriesDays ticket={shown} campus={campus} onResult={accept} />
          {shown.state === "active" && <CancelSeriesButton token={token} onResult={accept} />}
        </>
      )}
      <button type="button" class="button" onClick={() => goTo({ view: "book" })}>
        {t.book_another}
      </button>
    </section>
  );
}

interface CancelSeriesButtonProps {
  readonly token: string;
  readonly onResult: (result: Result<SeriesTicket>) => void;
}

function CancelSeriesButton({ token, onResult }: CancelSeriesButtonProps) {
  const confirming = useSignal(false);
  const t = texts.value;
  const cancel = async () => {
    confirming.value = false;
    const path = { token };
    onResult(await resultOf(api.POST("/api/v1/series/{token}/cancel", { params: { path } })));
  };
  return (
    <>
      <button
        type="button"
        class="button danger"
        onClick={() => {
          confirming.value = true;
        }}
      >
        {t.series_cancel}
      </button>
      {confirming.value && (
        <ConfirmDialog
          danger
          title={t.series_cancel_title}
          text={t.series_cancel_text}
          yes={t.series_cancel}
          no={t.cancel_no}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </>
  );
}
