import { useEffect } from "preact/hooks";
import { Loading, Note, ProblemNote } from "../../shared/ui/alerts";
import { closures, seriesList, service, timetable } from "../store/lists";
import { texts } from "../texts/texts";
import { CalendarList } from "./calendar_list";
import { ClosureBlock } from "./closure_list";
import { ExceptionList } from "./exception_list";
import { SeriesBlock } from "./series_list";
import { TimetableBlock } from "./trip_list";

/** On which days and at which hours the campus runs, and what runs today. */
export function ServicePage() {
  const t = texts.value;
  const shown = service.value.value;
  useEffect(() => {
    void service.refresh();
    void timetable.refresh();
    void seriesList.refresh();
    void closures.refresh();
  }, []);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.service}</h1>
      </header>
      {service.problem.value !== null && <ProblemNote problem={service.problem.value} />}
      {shown === null && service.problem.value === null && <Loading text={t.loading} />}
      {shown !== null && shown.rides_outside > 0 && (
        <Note tone="warning">{t.rides_outside(shown.rides_outside)}</Note>
      )}
      <div class="service-grid">
        {shown !== null && <ExceptionList shown={shown} />}
        {shown !== null && <CalendarList shown={shown} />}
        <ClosureBlock />
        <TimetableBlock />
        <SeriesBlock />
      </div>
    </section>
  );
}
