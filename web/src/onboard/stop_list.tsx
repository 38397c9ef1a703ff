import { language } from "../shared/texts/language";
import type { CabinView, CabinVisit } from "./screen_scene";
import { minutesTo } from "./screen_scene";
import { texts } from "./texts/texts";

const LATER_MAX = 3;

/** The next stop, large, and the riders' stops after it. */
export function StopList({ view }: { readonly view: CabinView | null }) {
  const t = texts.value;
  const [next, ...later] = view?.visits ?? [];
  return (
    <section class="stops">
      <h2>{t.next_stop}</h2>
      {view === null || next === undefined ? (
        <p class="next">{view === null ? t.unknown : t.no_stop}</p>
      ) : (
        <>
          <p class="next">{nameOf(next)}</p>
          <p class="when">
            <Arrival visit={next} view={view} />
          </p>
          <People visit={next} />
        </>
      )}
      {view !== null && later.length > 0 && (
        <ol aria-label={t.stops}>
          {later.slice(0, LATER_MAX).map((visit) => (
            <li key={visit.visit_id}>
              <strong>{nameOf(visit)}</strong>
              <span>
                <Arrival visit={visit} view={view} />
              </span>
              <People visit={visit} />
            </li>
          ))}
        </ol>
      )}
    </section>
  );
}

function nameOf(visit: CabinVisit): string {
  return language.value === "en" ? visit.name_en || visit.name : visit.name || visit.name_en;
}

function Arrival({ visit, view }: { readonly visit: CabinVisit; readonly view: CabinView }) {
  const t = texts.value;
  if (view.serving && visit === view.visits[0] && !view.early_stop) return <>{t.here}</>;
  const minutes = minutesTo(visit, view);
  return <>{minutes === null ? t.unknown : t.minutes(minutes)}</>;
}

function People({ visit }: { readonly visit: CabinVisit }) {
  const t = texts.value;
  const parts = [];
  if (visit.boarding > 0) parts.push(t.getting_on(visit.boarding));
  if (visit.alighting > 0) parts.push(t.getting_off(visit.alighting));
  return parts.length === 0 ? null : <span class="people">{parts.join(" · ")}</span>;
}
