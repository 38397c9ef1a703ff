import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { answerOf, api } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import type { Campus } from "../../shared/campus/campus";
import { nameOfStop } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { Note, ProblemNote } from "../../shared/ui/alerts";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { texts } from "../texts/texts";
import { storyOf } from "./ride_progress";
import { TicketCard } from "./ticket_card";

const ASK_EVERY_MS = 10_000;

interface CodePanelProps {
  readonly code: string;
  readonly campus: Campus;
}

/** A ride looked up by the code that can be said aloud. */
export function CodePanel({ code, campus }: CodePanelProps) {
  const typed = useSignal(code);
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
          goTo({ view: "find", code: typed.value.trim() });
        }}
      >
        <label for={id}>{t.code_label}</label>
        <div class="code-line">
          <input
            id={id}
            class="input code"
            value={typed.value}
            required
            minLength={6}
            maxLength={16}
            pattern="[A-Za-z0-9 \-]+"
            autocomplete="off"
            autocapitalize="characters"
            spellcheck={false}
            aria-describedby={`${id}-hint`}
            onInput={(event) => {
              typed.value = event.currentTarget.value;
            }}
          />
          <button class="button main">{t.find}</button>
        </div>
        <p class="hint" id={`${id}-hint`}>
          {t.code_hint}
        </p>
      </form>
      {code !== "" && <FoundRide key={code} code={code} campus={campus} />}
    </section>
  );
}

function FoundRide({ code, campus }: CodePanelProps) {
  const ride = useSignal<Schemas["RideView"] | null>(null);
  const problem = useSignal<Problem | null>(null);
  useEffect(() => {
    let left = false;
    const ask = async () => {
      const answer = await answerOf(
        api.GET("/api/v1/rides/lookup", { params: { query: { code } } }),
      );
      if (left) return;
      if (answer.ok) ride.value = answer.value;
      problem.value = answer.ok ? null : answer.problem;
    };
    void ask();
    const timer = window.setInterval(() => void ask(), ASK_EVERY_MS);
    return () => {
      left = true;
      clearInterval(timer);
    };
  }, [code]);
  const t = texts.value;
  if (problem.value !== null) return <ProblemNote problem={problem.value} />;
  if (ride.value === null) return <p role="status">{t.finding}</p>;
  const story = storyOf(ride.value, null, null);
  const name = (stop_id: string) => nameOfStop(campus.shape.stops, stop_id, language.value);
  const vehicle = ride.value.vehicle_id ?? t.shuttle;
  const headline = t[story.chapter];
  return (
    <>
      <h2>{typeof headline === "string" ? headline : headline(vehicle)}</h2>
      <TicketCard
        ticket={ride.value}
        vehicle={vehicle}
        from={name(ride.value.from_stop)}
        to={name(ride.value.to_stop)}
        view={campus.view}
        ended={story.ended}
      />
      <Note>{t.code_only}</Note>
    </>
  );
}
