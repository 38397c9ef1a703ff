import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { may } from "../session";
import { rides } from "../store/rides";
import { activeSeries } from "../store/series";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatDate } from "../texts/times";

type Series = Schemas["SeriesRecord"];

/** Passengers' active recurring bookings. */
export function SeriesList() {
  const t = texts.value;
  const shown = activeSeries.value.value;
  return (
    <section class="block card">
      <h2>{t.series}</h2>
      {activeSeries.problem.value !== null && <ProblemAlert problem={activeSeries.problem.value} />}
      {shown?.length === 0 && <p class="empty">{t.no_series}</p>}
      <ul class="rows">
        {shown?.map((series) => (
          <li key={series.series_id} data-series={series.series_id}>
            <SeriesRow series={series} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function SeriesRow({ series }: { readonly series: Series }) {
  const t = texts.value;
  const confirming = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const cancel = async () => {
    confirming.value = false;
    const path = { series_id: series.series_id };
    const result = await resultOf(
      api.POST("/api/v1/series/id/{series_id}/cancel", { params: { path } }),
    );
    problem.value = result.ok ? null : result.problem;
    await Promise.all([activeSeries.refresh(), rides.refresh()]);
  };
  const days = series.weekdays.map((day) => weekdayName(day, language.value, "short")).join(" ");
  return (
    <div class="line">
      <span>
        <strong>
          {stopName(series.from_stop)} – {stopName(series.to_stop)}
        </strong>
        <small>
          {days} {series.leave} · {t.until_day(formatDate(series.ends_on))} ·{" "}
          {t.people_count(series.party)}
        </small>
      </span>
      {may("dispatcher") && (
        <button
          type="button"
          class="button small"
          onClick={() => {
            confirming.value = true;
          }}
        >
          {t.cancel_ride}
        </button>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      {confirming.value && (
        <ConfirmDialog
          danger
          title={t.cancel_series_title}
          text={t.cancel_series_text}
          yes={t.cancel_series_yes}
          no={t.cancel}
          onNo={() => {
            confirming.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </div>
  );
}
