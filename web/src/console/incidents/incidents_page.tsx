import { useSignal } from "@preact/signals";
import { Loading, ProblemAlert } from "../../shared/ui/alerts";
import { AnnounceManyDialog } from "../announcements/announce_many_dialog";
import { may } from "../session";
import { incidents, includeClosed } from "../store/incidents";
import { vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import type { Grouping } from "./incident_groups";
import { groupIncidents } from "./incident_groups";
import { IncidentList } from "./incident_list";
import { ShiftLog } from "./shift_log";
import { is_sound_on, playIncidentSound } from "./incident_sound";

const GROUPINGS: readonly Grouping[] = ["none", "kind", "vehicle"];

export function IncidentsPage() {
  const t = texts.value;
  const grouping = useSignal<Grouping>("none");
  const is_announcing = useSignal(false);
  const shown = incidents.value.value;
  const toggleSound = (is_on: boolean) => {
    is_sound_on.value = is_on;
    if (is_on) playIncidentSound();
  };
  return (
    <section class="sheet narrow">
      <header class="sheet-head">
        <h1>{t.incidents}</h1>
        <div class="buttons">
          {may("dispatcher") && (
            <button type="button" class="button" onClick={() => (is_announcing.value = true)}>
              {t.announce_to_shuttles}
            </button>
          )}
          <div class="switch" role="group" aria-label={t.group_incidents}>
            {GROUPINGS.map((each) => (
              <button
                key={each}
                type="button"
                aria-pressed={grouping.value === each}
                onClick={() => (grouping.value = each)}
              >
                {t.groupings[each]}
              </button>
            ))}
          </div>
          <label class="check">
            <input
              type="checkbox"
              checked={is_sound_on.value}
              onChange={(event) => toggleSound(event.currentTarget.checked)}
            />
            {t.incident_sound}
          </label>
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
        </div>
      </header>
      {incidents.problem.value !== null && <ProblemAlert problem={incidents.problem.value} />}
      {shown === null ? (
        <Loading text={t.loading} />
      ) : grouping.value === "none" ? (
        <IncidentList shown={shown} heading="h2" />
      ) : (
        groupIncidents(shown, grouping.value).map((group) => (
          <section key={group.key} class="incident-group" data-group={group.key}>
            <h2>
              {grouping.value === "kind"
                ? t.kinds[group.incidents[0]!.kind]
                : group.key === ""
                  ? t.no_vehicle_of_incident
                  : vehicleName(group.key)}{" "}
              <span class="count">{group.incidents.length}</span>
            </h2>
            <IncidentList shown={group.incidents} heading="h3" />
          </section>
        ))
      )}
      <ShiftLog />
      {is_announcing.value && <AnnounceManyDialog onClose={() => (is_announcing.value = false)} />}
    </section>
  );
}
