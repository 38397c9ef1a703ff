import { Loading, ProblemNote } from "../shared/ui/notes";
import { IncidentList } from "./incident_list";
import { incidents, withClosed } from "./lists";
import { words } from "./words";

export function IncidentsPage() {
  const say = words.value;
  const shown = incidents.value.value;
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{say.incidents}</h1>
        <label class="check">
          <input
            type="checkbox"
            checked={withClosed.value}
            onChange={(event) => {
              withClosed.value = event.currentTarget.checked;
              void incidents.refresh();
            }}
          />
          {say.with_closed}
        </label>
      </header>
      {incidents.problem.value !== null && <ProblemNote problem={incidents.problem.value} />}
      {shown === null ? <Loading text={say.loading} /> : <IncidentList shown={shown} />}
    </section>
  );
}
