import { serverNow_ms } from "../../shared/api/server_time";
import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../campus/campus";
import { stopNameById } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { rideProgress } from "./ride_progress";
import { titleText } from "./ride_texts";
import { TicketCard } from "./ticket_card";

const REFRESH_MS = 10_000;

interface RideLookupPanelProps {
  readonly code: string;
  readonly campus: Campus;
}

/** A ride looked up by the code that a passenger can say aloud. */
export function RideLookupPanel({ code, campus }: RideLookupPanelProps) {
  const typed_code = useSignal(code);
  const id = useId();
  const t = texts.value;
  return (
    <section class="ride">
      <div>
        <button type="button" class="button quiet small" onClick={() => goTo({ view: "book" })}>
          <BackIcon />
          {t.back}
        </button>
      </div>
      <h1>{t.code_title}</h1>
      <form
        class="field"
        onSubmit={(event) => {
          event.preventDefault();
          goTo({ view: "find", code: typed_code.value.trim() });
        }}
      >
        <label for={id}>{t.code_label}</label>
        <div class="code-line">
          <input
            id={id}
            class="input code"
            value={typed_code.value}
            required
            minLength={6}
            maxLength={16}
            pattern="[A-Za-z0-9 \-]+"
            autocomplete="off"
            autocapitalize="characters"
            spellcheck={false}
            aria-describedby={`${id}-hint`}
            onInput={(event) => {
              typed_code.value = event.currentTarget.value;
            }}
          />
          <button class="button main">{t.find}</button>
        </div>
        <p class="hint" id={`${id}-hint`}>
          {t.code_hint}
        </p>
      </form>
      {code !== "" && <RideLookupResult key={code} code={code} campus={campus} />}
    </section>
  );
}

function RideLookupResult({ code, campus }: RideLookupPanelProps) {
  const ride = useSignal<Schemas["RideView"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  useEffect(() => {
    let closed = false;
    const load = async () => {
      const result = await resultOf(
        api.GET("/api/v1/rides/lookup", { params: { query: { code } } }),
      );
      if (closed) return;
      if (result.ok) ride.value = result.value;
      problem.value = result.ok ? null : result.problem;
    };
    void load();
    const timer = window.setInterval(() => void load(), REFRESH_MS);
    return () => {
      closed = true;
      clearInterval(timer);
    };
  }, [code]);
  const t = texts.value;
  if (problem.value !== null) return <ProblemAlert problem={problem.value} />;
  if (ride.value === null) return <p role="status">{t.finding}</p>;
  const progress = rideProgress(ride.value, null, null, {
    now_ms: serverNow_ms(),
    known_ms: serverNow_ms(),
  });
  const name = (stop_id: string) => stopNameById(campus.stops, stop_id, language.value);
  const vehicle = ride.value.vehicle_name || t.shuttle;
  return (
    <>
      <h2>{titleText(progress.phase, vehicle)}</h2>
      <TicketCard
        ticket={ride.value}
        vehicle={vehicle}
        from={name(ride.value.from_stop)}
        to={name(ride.value.to_stop)}
        view={campus.view}
        ended={progress.ended}
      />
      <Alert>{t.code_only}</Alert>
    </>
  );
}
