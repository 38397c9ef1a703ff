import type { Schemas } from "../../shared/api/client";
import { fromLocalInput } from "../../shared/texts/times";

export type AnnouncementBody = Schemas["AnnouncementBody"];
export type Audience = Schemas["AnnouncementView"]["audience"];

/** As the server has it: what is read from some metres away, and heard in one go. */
export const TEXT_CHARACTERS_MAX = 280;

/** What an operator has entered; nothing chosen means all stops or all shuttles. */
export interface AnnouncementDraft {
  readonly text_zh: string;
  readonly text_en: string;
  readonly audience: Audience;
  readonly chosen: readonly string[];
  /** Local times of the campus, "" for none. */
  readonly from: string;
  readonly until: string;
}

export function bodyOf(draft: AnnouncementDraft, timezone: string): AnnouncementBody {
  const time = (local: string) => fromLocalInput(local, timezone)?.toISOString() ?? null;
  return {
    text_zh: draft.text_zh.trim(),
    text_en: draft.text_en.trim(),
    audience: draft.audience,
    stop_ids: draft.audience === "stops" ? [...draft.chosen] : [],
    vehicle_ids: draft.audience === "shuttles" ? [...draft.chosen] : [],
    starts_at: time(draft.from),
    ends_at: time(draft.until),
  };
}
