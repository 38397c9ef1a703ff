import { useSignal } from "@preact/signals";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { goTo } from "../navigation";
import { may } from "../session";
import { incidents } from "../store/incidents";
import { rideCode, vehicleName } from "../texts/names";
import { texts } from "../texts/texts";
import { formatTimeOrDateTime } from "../texts/times";
import { IncidentNotes } from "./incident_notes";
import { incidentText } from "./incident_text";

type Incident = Schemas["IncidentView"];

interface IncidentListProps {
  readonly shown: readonly Incident[];
  /** One level below the heading that the list is under. */
  readonly heading: "h2" | "h3";
}

/** Help calls differ from other incidents by position, size and text as well as by colour. */
export function IncidentList({ shown, heading }: IncidentListProps) {
  const t = texts.value;
  if (shown.length === 0) return <p class="empty">{t.no_incidents}</p>;
  return (
    <ul class="incidents">
      {shown.map((incident) => (
        <li key={incident.incident_id}>
          <IncidentCard incident={incident} heading={heading} />
        </li>
      ))}
    </ul>
  );
}

interface IncidentCardProps {
  readonly incident: Incident;
  readonly heading: "h2" | "h3";
}

function IncidentCard({ incident, heading: Heading }: IncidentCardProps) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const is_open = incident.closed_at === null;
  const is_new = is_open && incident.acknowledged_at === null;
  const act = async (verb: "acknowledge" | "close") => {
    const path = { params: { path: { incident_id: incident.incident_id } } };
    const result = await resultOf(
      verb === "acknowledge"
        ? api.POST("/api/v1/incidents/{incident_id}/acknowledge", path)
        : api.POST("/api/v1/incidents/{incident_id}/close", path),
    );
    problem.value = result.ok ? null : result.problem;
    await incidents.refresh();
  };
  const { cause, action, report } = incidentText(incident);
  const code = incident.ride_id === null ? "" : rideCode(incident.ride_id);
  const severity = incident.priority === 0 ? "help" : incident.priority < 30 ? "severe" : "";
  return (
    <article
      class={`incident ${severity} ${is_new ? "new" : ""} ${is_open ? "" : "over"}`}
      data-kind={incident.kind}
    >
      <header>
        <Heading>{t.kinds[incident.kind]}</Heading>
        <time>{formatTimeOrDateTime(incident.opened_at)}</time>
      </header>
      <p>{cause}</p>
      {is_open && <p class="incident-action">{action}</p>}
      {report !== "" && (
        <details>
          <summary>{t.report}</summary>
          <p>{report}</p>
        </details>
      )}
      <p class="incident-facts">
        {incident.vehicle_id !== null && (
          <button
            type="button"
            class="plain-link"
            onClick={() => goTo("live", incident.vehicle_id!)}
          >
            {vehicleName(incident.vehicle_id)}
          </button>
        )}
        {code !== "" && (
          <span>
            {t.ride} {code}
          </span>
        )}
        {incident.acknowledged_by !== "" && <span>{t.seen_by(incident.acknowledged_by)}</span>}
        {!is_open && <span>{t.closed_by(incident.closed_by)}</span>}
      </p>
      <IncidentNotes incident_id={incident.incident_id} />
      {is_open && may("dispatcher", "safety") && (
        <div class="buttons">
          {is_new && (
            <button type="button" class="button small main" onClick={() => void act("acknowledge")}>
              {t.acknowledge}
            </button>
          )}
          <button type="button" class="button small" onClick={() => void act("close")}>
            {t.close}
          </button>
        </div>
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </article>
  );
}
