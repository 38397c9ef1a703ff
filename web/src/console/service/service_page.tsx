import { useEffect } from "preact/hooks";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { AnnouncementList } from "../announcements/announcement_list";
import { ClosureList } from "../closures/closure_list";
import { closures } from "../store/closures";
import { activeSeries } from "../store/series";
import { service, timetable } from "../store/service";
import { texts } from "../texts/texts";
import { BoardLinks } from "./board_links";
import { CalendarList } from "./calendar_list";
import { ExceptionList } from "./exception_list";
import { SeriesList } from "./series_list";
import { TripList } from "./trip_list";

/** The days and hours of service, closures, today's trips and recurring bookings. */
export function ServicePage() {
  const t = texts.value;
  const shown = service.value.value;
  useEffect(() => {
    void service.refresh();
    void timetable.refresh();
    void activeSeries.refresh();
    void closures.refresh();
  }, []);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.service}</h1>
      </header>
      {service.problem.value !== null && <ProblemAlert problem={service.problem.value} />}
      {shown === null && service.problem.value === null && <Loading text={t.loading} />}
      {shown !== null && shown.rides_outside > 0 && (
        <Alert tone="warning">{t.rides_outside(shown.rides_outside)}</Alert>
      )}
      <div class="service-grid">
        {shown !== null && <ExceptionList shown={shown} />}
        {shown !== null && <CalendarList shown={shown} />}
        <AnnouncementList />
        <ClosureList />
        <TripList />
        <SeriesList />
        <BoardLinks />
      </div>
    </section>
  );
}
