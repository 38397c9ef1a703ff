import type { CabinView } from "./screen_scene";
import { peopleSeen } from "./screen_scene";
import { texts } from "./texts/texts";

/** Speed, why the shuttle does not go faster, and the people that it sees. */
export function DrivingFacts({ view }: { readonly view: CabinView | null }) {
  const t = texts.value;
  const people = view === null ? null : peopleSeen(view);
  const speed = view === null ? null : Math.abs(view.status.speed_mps) * 3.6;
  return (
    <dl class="facts">
      <div>
        <dt>{t.speed}</dt>
        <dd>{speed === null ? t.unknown : t.kmh(speed.toFixed(0))}</dd>
      </div>
      <div>
        <dt>{t.because}</dt>
        <dd>{view === null ? t.unknown : t.limits[view.limited_by]}</dd>
      </div>
      <div>
        <dt>{t.people}</dt>
        <dd>{people === null ? t.unknown : t.people_seen(people.seen, people.yielded_to)}</dd>
      </div>
    </dl>
  );
}
