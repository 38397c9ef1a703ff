import type { Schemas } from "../../shared/api/client";
import { withNames } from "../texts/names";
import type { ConsoleTexts } from "../texts/texts_en";
import { texts } from "../texts/texts";
import { lidarFault } from "./lidar_fault";

type Incident = Schemas["IncidentView"];
type FaultActions = ConsoleTexts["fault_actions"];

export interface IncidentText {
  /** What has happened. */
  readonly cause: string;
  /** What an operator can do about it. */
  readonly action: string;
  /** What the server or the shuttle reports besides; "" for nothing more. */
  readonly report: string;
}

export function incidentText({ kind, cause }: Incident): IncidentText {
  const t = texts.value;
  const codes = faultCodes(cause);
  const fault = lidarFault(cause);
  if (fault !== null) {
    const { code, lidar } = fault;
    return { cause: t.lidar_causes[code](lidar), action: t.lidar_actions[code](lidar), report: "" };
  }
  if (kind === "help_call") {
    const said = /calls for help: (.*)$/s.exec(cause)?.[1] ?? cause;
    const message = said === "no message" ? t.incident_causes.help_call : `“${said}”`;
    return { cause: message, action: t.incident_actions.help_call, report: "" };
  }
  if (codes.length > 0) {
    const names = codes.map((code) => t.fault_codes[code as keyof typeof t.fault_codes]);
    return {
      cause: `${t.incident_causes[kind]} ${t.fault_is(names.join(", "))}`,
      action: t.fault_actions[familyOf(codes[0]!)],
      report: "",
    };
  }
  const report = kind === "takeover" ? "" : withNames(cause);
  return { cause: t.incident_causes[kind], action: t.incident_actions[kind], report };
}

function faultCodes(cause: string): readonly string[] {
  const named = cause.split(/[,\s]+/).filter(Boolean);
  return named.every((code) => code in texts.value.fault_codes) ? named : [];
}

/** What is broken decides who can help. */
function familyOf(code: string): keyof FaultActions {
  if (code.startsWith("gate_braking")) return "gate";
  if (/^(emergency_stop|stop_button)/.test(code)) return "stop_button";
  if (/^(bywire|by_wire|can)_/.test(code)) return "by_wire";
  return /^(pose|percept|lidar|tracks|motion)_/.test(code) ? "sensors" : "computer";
}
