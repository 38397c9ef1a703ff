import { Loading, ProblemNote } from "../../shared/ui/notes";
import { incidents, withClosed } from "../store/lists";
import { words } from "../texts/words";
import { IncidentList } from "./incident_list";

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
