import { Loading, ProblemAlert } from "../../shared/ui/alerts";
import { incidents, includeClosed } from "../store/incidents";
import { texts } from "../texts/texts";
import { IncidentList } from "./incident_list";

export function IncidentsPage() {
  const t = texts.value;
  const shown = incidents.value.value;
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{t.incidents}</h1>
        <label class="check">
          <input
            type="checkbox"
            checked={includeClosed.value}
            onChange={(event) => {
              includeClosed.value = event.currentTarget.checked;
              void incidents.refresh();
            }}
          />
          {t.with_closed}
        </label>
      </header>
      {incidents.problem.value !== null && <ProblemAlert problem={incidents.problem.value} />}
      {shown === null ? <Loading text={t.loading} /> : <IncidentList shown={shown} heading="h2" />}
    </section>
  );
}
