import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Alert, Loading, ProblemAlert } from "../../shared/ui/alerts";
import { may } from "../session";
import { rides, rideSearch } from "../store/rides";
import { texts } from "../texts/texts";
import { CallerBookingDialog } from "./caller_booking_dialog";
import { RideSearchForm } from "./ride_search_form";
import { RideTable } from "./ride_table";

export function RidesPage() {
  const t = texts.value;
  const is_booking = useSignal(false);
  const shown = rides.value.value;
  const { open_only } = rideSearch.value;
  useEffect(() => void rides.refresh(), []);
  const filter = (open_only: boolean) => {
    rideSearch.value = { ...rideSearch.peek(), open_only };
    rides.clear();
    void rides.refresh();
  };
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.rides}</h1>
        <div class="buttons">
          {may("dispatcher") && (
            <button type="button" class="button main" onClick={() => (is_booking.value = true)}>
              {t.book_for_caller}
            </button>
          )}
          <div class="switch">
            <button type="button" aria-pressed={open_only} onClick={() => filter(true)}>
              {t.rides_open}
            </button>
            <button type="button" aria-pressed={!open_only} onClick={() => filter(false)}>
              {t.rides_all}
            </button>
          </div>
        </div>
      </header>
      <RideSearchForm />
      {rides.problem.value !== null && <ProblemAlert problem={rides.problem.value} />}
      {shown === null && rides.problem.value === null && <Loading text={t.loading} />}
      {shown?.length === 0 && <Alert>{t.no_rides}</Alert>}
      {shown !== null && shown.length > 0 && <RideTable shown={shown} />}
      {is_booking.value && <CallerBookingDialog onClose={() => (is_booking.value = false)} />}
    </section>
  );
}
