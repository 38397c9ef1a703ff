import type { Schemas } from "../../shared/api/client";

type State = Schemas["AnnouncementView"]["state"];
type Audience = Schemas["AnnouncementView"]["audience"];

/** What the console says of announcements to riders. */
export const announcementEn = {
  announcements: "Announcements to riders",
  announcements_lead:
    "Shown on stop boards, on phones and in shuttles from their beginning to their end. Shuttles also say them aloud.",
  announcement_zh: "Text in Chinese",
  announcement_en: "Text in English",
  announcement_length: (left: number) => `${left} characters left.`,
  audience: "To",
  audiences: {
    all: "All: boards, phones and shuttles",
    stops: "Stops: boards, and riders from or to there",
    shuttles: "Shuttles: said and shown on board",
  } satisfies Readonly<Record<Audience, string>> as Record<Audience, string>,
  which_stops: "Which stops",
  every_stop: "All stops",
  every_shuttle: "All shuttles",
  announcement_from: "From (empty: now)",
  announcement_until: "Until (empty: until you end it)",
  announcement_preview: "Preview",
  announcement_preview_title: "Tell riders this?",
  on_a_board: "On a board and on a phone",
  publish_announcement: "Announce to riders",
  announcement_states: {
    scheduled: "scheduled",
    current: "shown now",
    over: "over",
  } satisfies Readonly<Record<State, string>> as Record<State, string>,
  end_announcement: "End",
  announcement_until_ended: "until it is ended",
  announcement_ended_by: (name: string, time: string) => `ended by ${name}, ${time}`,
  no_announcements: "There are no announcements.",
};
