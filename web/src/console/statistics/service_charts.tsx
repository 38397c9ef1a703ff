import type { Schemas } from "../../shared/api/client";
import { Alert } from "../../shared/ui/alerts";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { BarChart } from "./bar_chart";
import { FigureTable } from "./figure_table";

type ServiceFigures = Readonly<Schemas["ServiceFigures"]>;

/** Demand by the hour, how rides went, how long people waited, and the busiest ways. */
export function ServiceCharts({ figures }: { readonly figures: ServiceFigures }) {
  const t = texts.value;
  const outcomes = ["completed", "under_way", "refused", "cancelled", "no_show", "failed"] as const;
  const names = outcomes.map((outcome) => t.ride_outcomes[outcome]);
  const rides = figures.hours.reduce(
    (total, hour) => total + outcomes.reduce((all, outcome) => all + hour[outcome], 0),
    0,
  );
  const passengers = figures.hours.reduce((total, hour) => total + hour.passengers, 0);
  const { waiting_s, late_s } = figures;
  return (
    <section class="block" aria-label={t.demand}>
      <h2>{t.demand}</h2>
      {figures.is_cut && <Alert>{t.figures_cut}</Alert>}
      {rides === 0 && <Alert>{t.no_rides_wanted}</Alert>}
      {rides > 0 && (
        <>
          <p>{t.rides_and_passengers(rides, passengers)}</p>
          <p>
            {waiting_s.count > 0 &&
              t.waited(minutes(waiting_s.p50), minutes(waiting_s.p90), minutes(waiting_s.p99))}{" "}
            {late_s.count > 0 && t.promises_kept((100 * figures.kept_ratio).toFixed(1))}
          </p>
          <BarChart
            title={t.rides_by_hour}
            kinds={names}
            bars={figures.hours.map((hour) => ({
              label: String(hour.hour),
              parts: outcomes.map((outcome) => hour[outcome]),
            }))}
          />
          <FigureTable
            title={t.rides_by_hour}
            file_name="rides-by-hour.csv"
            header={[t.hour, ...names, t.passengers]}
            rows={figures.hours.map((hour) => [
              hour.hour,
              ...outcomes.map((outcome) => hour[outcome]),
              hour.passengers,
            ])}
          />
          <FigureTable
            title={t.busiest_ways}
            file_name="busiest-ways.csv"
            header={[t.way_from, t.way_to, t.rides]}
            rows={figures.pairs.map((pair) => [
              stopName(pair.from_stop),
              stopName(pair.to_stop),
              pair.rides,
            ])}
          />
        </>
      )}
    </section>
  );
}

function minutes(seconds: number): string {
  return (seconds / 60).toFixed(1);
}
