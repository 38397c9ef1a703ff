import { useEffect } from "preact/hooks";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { openRidesOnly, rides } from "../store/rides";
import { texts } from "../texts/texts";
import { RideTable } from "./ride_table";

export function RidesPage() {
  const t = texts.value;
  const shown = rides.value.value;
  useEffect(() => void rides.refresh(), []);
  const filter = (open_only: boolean) => {
    openRidesOnly.value = open_only;
    rides.clear();
    void rides.refresh();
  };
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.rides}</h1>
        <div class="switch">
          <button type="button" aria-pressed={openRidesOnly.value} onClick={() => filter(true)}>
            {t.rides_open}
          </button>
          <button type="button" aria-pressed={!openRidesOnly.value} onClick={() => filter(false)}>
            {t.rides_all}
          </button>
        </div>
      </header>
      {rides.problem.value !== null && <ProblemAlert problem={rides.problem.value} />}
      {shown === null && rides.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <Alert>{t.no_rides}</Alert>}
      {shown !== null && shown.length > 0 && <RideTable shown={shown} />}
    </section>
  );
}
