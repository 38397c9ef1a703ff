import { vehicleName } from "../texts/names";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";
import { formatTimeWithSeconds } from "../texts/times";
import { type Mark, nextMark } from "./marks";
import type { PlaybackClock } from "./playback_clock";

/** What is listed around the present moment. */
const BEFORE = 4;
const AFTER = 8;

interface MarkListProps {
  /** Oldest first. */
  readonly marks: readonly Mark[];
  readonly clock: PlaybackClock;
}

/** What happened around this moment, in words; each line goes there. */
export function MarkList({ marks, clock }: MarkListProps) {
  const t = texts.value;
  const at_ms = clock.at_ms.value;
  const next = nextMark(marks, at_ms, 1);
  const place = next === undefined ? marks.length : marks.indexOf(next);
  const shown = marks.slice(Math.max(place - BEFORE, 0), place + AFTER);
  return (
    <section class="block" aria-label={t.happened}>
      <h2>{t.happened}</h2>
      {marks.length === 0 && <p class="empty">{t.nothing_happened}</p>}
      <ol class="plain marks">
        {shown.map((mark, k) => (
          <li key={`${mark.at_ms} ${mark.kind} ${mark.vehicle_id} ${k}`}>
            <button
              type="button"
              class={mark.at_ms <= at_ms ? "row past" : "row"}
              onClick={() => clock.seek(mark.at_ms)}
            >
              <time>{formatTimeWithSeconds(mark.at_ms)}</time> {markText(mark)}
            </button>
          </li>
        ))}
      </ol>
    </section>
  );
}

function markText(mark: Mark): string {
  const { kind, vehicle_id, stop_id, detail, by } = mark;
  const t = texts.value;
  const who = vehicle_id === "" ? "" : `${vehicleName(vehicle_id)}: `;
  if (kind === "stop") return `${who}${t.mark_stop(stop_id === "" ? "" : stopName(stop_id))}`;
  if (kind === "incident" && detail in t.incident_causes)
    return `${who}${t.incident_causes[detail as keyof typeof t.incident_causes]}`;
  if (kind === "note" || kind === "recording") return `${who}${operatorMarkText(mark)}`;
  if (kind === "intervention") {
    const what = t.mark_interventions[detail as keyof typeof t.mark_interventions] ?? detail;
    return `${who}${what}${by === "" ? "" : ` (${by})`}`;
  }
  const cause =
    detail in t.braking_by
      ? t.braking_by[detail]
      : detail in t.fault_codes
        ? t.fault_codes[detail as keyof typeof t.fault_codes]
        : detail in t.hold_reasons
          ? t.hold_reasons[detail as keyof typeof t.hold_reasons]
          : "";
  return `${who}${t.mark_kinds[kind]}${cause === "" ? "" : `: ${cause}`}`;
}

/** An operator's note or a recording's end, by whom, and whether the shuttle's file has it. */
function operatorMarkText({ kind, detail, by, text }: Mark): string {
  const t = texts.value;
  const [name = "", state = ""] = detail.split(" ");
  const what = kind === "note" ? t.mark_kinds.note : (t.recording_ends[name] ?? t.mark_kinds[kind]);
  const whose = by === "" ? "" : ` (${by})`;
  const missing =
    state === "pending" ? `, ${t.mark_waits}` : state === "failed" ? `, ${t.mark_refused}` : "";
  return `${what}: “${text}”${whose}${missing}`;
}
