import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { api, resultOf, type Schemas } from "../../shared/api/client";
import type { Result } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { Loading } from "../../shared/ui/alerts";
import { FailedLoad } from "../failed_load";
import { SelectField } from "../forms/select_field";
import { TextField } from "../forms/text_field";
import { dayAfter, dayOf, daysLater, startOfDay_ms } from "../runs/fleet/campus_day";
import { texts } from "../texts/texts";
import { now_ms } from "../texts/times";
import { DrivingCharts } from "./driving_charts";
import { ServiceCharts } from "./service_charts";

type ServiceFigures = Schemas["ServiceFigures"];
type DrivingFigures = Schemas["DrivingFigures"];

/** The stretches that one can look at: days that end with the chosen one. */
const DAYS = [1, 7, 28] as const;

/** Demand, service and driving, as numbers and as bars. */
export function StatisticsPage({ campus }: { readonly campus: Campus }) {
  const t = texts.value;
  const { timezone } = campus.view;
  const today = dayOf(now_ms(), timezone);
  const date = useSignal(today);
  const days = useSignal("7");
  const service = useSignal<Result<ServiceFigures> | null>(null);
  const driving = useSignal<Result<DrivingFigures> | null>(null);
  const attempt = useSignal(0);
  const retry = () => {
    attempt.value += 1;
  };
  useEffect(() => {
    let is_current = true;
    service.value = null;
    driving.value = null;
    const end_ms = startOfDay_ms(dayAfter(date.value), timezone);
    const start_ms = startOfDay_ms(date.value, timezone);
    const first_ms = startOfDay_ms(daysLater(date.value, 1 - Number(days.value)), timezone);
    void loadService(first_ms, end_ms).then((result) => {
      if (is_current) service.value = result;
    });
    void loadDriving(start_ms, end_ms).then((result) => {
      if (is_current) driving.value = result;
    });
    return () => {
      is_current = false;
    };
  }, [date.value, days.value, timezone, attempt.value]);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.statistics}</h1>
      </header>
      <div class="row-form">
        <TextField
          label={t.figures_until}
          value={date}
          input={{ type: "date", max: today, required: true }}
        />
        <SelectField
          label={t.stretch}
          value={days.value}
          options={DAYS.map((count) => [String(count), t.days_shown(count)] as const)}
          onChange={(value) => {
            days.value = value;
          }}
        />
      </div>
      <Loaded result={service.value} onRetry={retry}>
        {(figures) => <ServiceCharts figures={figures} />}
      </Loaded>
      <p class="hint">{t.driving_is_of_a_day}</p>
      <Loaded result={driving.value} onRetry={retry}>
        {(figures) => <DrivingCharts figures={figures} />}
      </Loaded>
    </section>
  );
}

interface LoadedProps<T> {
  readonly result: Result<T> | null;
  readonly onRetry: () => void;
  readonly children: (value: T) => preact.JSX.Element;
}

function Loaded<T>({ result, onRetry, children }: LoadedProps<T>) {
  if (result === null) return <Loading text={texts.value.loading} />;
  if (!result.ok) return <FailedLoad problem={result.problem} onRetry={onRetry} />;
  return children(result.value);
}

function loadService(from_ms: number, to_ms: number): Promise<Result<ServiceFigures>> {
  const query = { from_ms, seconds: (to_ms - from_ms) / 1000 };
  return resultOf(api.GET("/api/v1/statistics/service", { params: { query } })) as Promise<
    Result<ServiceFigures>
  >;
}

function loadDriving(from_ms: number, to_ms: number): Promise<Result<DrivingFigures>> {
  const query = { from_ms, seconds: (to_ms - from_ms) / 1000 };
  return resultOf(api.GET("/api/v1/statistics/driving", { params: { query } })) as Promise<
    Result<DrivingFigures>
  >;
}
