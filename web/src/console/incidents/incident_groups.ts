import type { Schemas } from "../../shared/api/client";

type Incident = Schemas["IncidentView"];

export type Grouping = "none" | "kind" | "vehicle";

export interface IncidentGroup {
  /** The kind or the vehicle; "" for incidents of no vehicle. */
  readonly key: string;
  readonly incidents: readonly Incident[];
}

/** Groups in the order of their first incident: the list is sorted by urgency, and stays so. */
export function groupIncidents(
  incidents: readonly Incident[],
  by: Exclude<Grouping, "none">,
): readonly IncidentGroup[] {
  const groups = new Map<string, Incident[]>();
  for (const incident of incidents) {
    const key = by === "kind" ? incident.kind : (incident.vehicle_id ?? "");
    const group = groups.get(key);
    if (group === undefined) groups.set(key, [incident]);
    else group.push(incident);
  }
  return [...groups].map(([key, members]) => ({ key, incidents: members }));
}
