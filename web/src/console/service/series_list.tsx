import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { weekdayName } from "../../shared/texts/times";
import { ProblemNote } from "../../shared/ui/alerts";
import { Question } from "../../shared/ui/dialog";
import { rides, seriesList } from "../store/lists";
import { stopTitle } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { calendarDate } from "../texts/times";

type Series = Schemas["SeriesRecord"];

/** Passengers' recurring bookings that still go on. */
export function SeriesBlock() {
  const t = texts.value;
  const shown = seriesList.value.value;
  return (
    <section class="block card">
      <h2>{t.series}</h2>
      {seriesList.problem.value !== null && <ProblemNote problem={seriesList.problem.value} />}
      {shown?.length === 0 && <p class="empty">{t.no_series}</p>}
      <ul class="rows">
        {shown?.map((series) => (
          <li key={series.series_id} data-series={series.series_id}>
            <SeriesLine series={series} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function SeriesLine({ series }: { readonly series: Series }) {
  const t = texts.value;
  const asking = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const cancel = async () => {
    asking.value = false;
    const path = { series_id: series.series_id };
    const answer = await answerOf(
      api.POST("/api/v1/series/id/{series_id}/cancel", { params: { path } }),
    );
    problem.value = answer.ok ? null : answer.problem;
    await Promise.all([seriesList.refresh(), rides.refresh()]);
  };
  const days = series.weekdays.map((day) => weekdayName(day, language.value, "short")).join(" ");
  return (
    <div class="line">
      <span>
        <strong>
          {stopTitle(series.from_stop)} – {stopTitle(series.to_stop)}
        </strong>
        <small>
          {days} {series.leave} · {t.until_day(calendarDate(series.ends_on))} ·{" "}
          {t.people_count(series.party)}
        </small>
      </span>
      <button
        type="button"
        class="button small"
        onClick={() => {
          asking.value = true;
        }}
      >
        {t.cancel_ride}
      </button>
      {problem.value !== null && <ProblemNote problem={problem.value} />}
      {asking.value && (
        <Question
          danger
          title={t.cancel_series_title}
          text={t.cancel_series_text}
          yes={t.cancel_series_yes}
          no={t.cancel}
          onNo={() => {
            asking.value = false;
          }}
          onYes={() => void cancel()}
        />
      )}
    </div>
  );
}
