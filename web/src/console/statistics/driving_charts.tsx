import type { Schemas } from "../../shared/api/client";
import { Alert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import { BarChart } from "./bar_chart";
import { FigureTable } from "./figure_table";

type DrivingFigures = Readonly<Schemas["DrivingFigures"]>;

/** How fast the shuttles drove, how far, and what interrupted them. */
export function DrivingCharts({ figures }: { readonly figures: DrivingFigures }) {
  const t = texts.value;
  const { speeds, distance_m, takeovers, brakings, minimal_risk_stops } = figures;
  const moving = speeds.filter((bin) => bin.from_kmh > 0);
  const all = moving.reduce((total, bin) => total + bin.positions, 0);
  const share = (positions: number) => ((100 * positions) / Math.max(all, 1)).toFixed(1);
  const km = distance_m / 1000;
  return (
    <section class="block" aria-label={t.driving}>
      <h2>{t.driving}</h2>
      {figures.is_cut && <Alert tone="warning">{t.events_cut}</Alert>}
      {all === 0 && <Alert>{t.nothing_driven}</Alert>}
      {all > 0 && (
        <>
          <p>
            {t.driven(km.toFixed(1))} {t.interruptions(takeovers, minimal_risk_stops, brakings)}{" "}
            {takeovers > 0 && t.km_per_takeover((km / takeovers).toFixed(1))}
          </p>
          <BarChart
            title={t.speed_shares}
            kinds={[t.speed_shares]}
            bars={moving.map((bin) => ({ label: String(bin.from_kmh), parts: [bin.positions] }))}
          />
          <FigureTable
            title={t.speed_shares}
            file_name="speeds.csv"
            header={[t.speed_from, t.share_percent]}
            rows={moving.map((bin) => [bin.from_kmh, share(bin.positions)])}
          />
        </>
      )}
    </section>
  );
}
