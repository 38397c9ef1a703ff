import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { language } from "../../shared/texts/language";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { announcements } from "../store/announcements";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { AnnouncementForm } from "./announcement_form";
import { addresseesOf, timesOf } from "./announcement_text";

type Announcement = Schemas["AnnouncementView"];

const TONES: Readonly<Record<Announcement["state"], string>> = {
  scheduled: "calm",
  current: "warning",
  over: "calm",
};
/** Their state changes by the clock alone. */
const REFRESH_MS = 20_000;

/** What riders are told now, will be told and were told; the operator writes, previews and ends it here. */
export function AnnouncementList() {
  const t = texts.value;
  const shown = announcements.value.value;
  useEffect(() => {
    void announcements.refresh();
    const timer = window.setInterval(() => void announcements.refresh(), REFRESH_MS);
    return () => clearInterval(timer);
  }, []);
  return (
    <section class="block card announcements">
      <h2>{t.announcements}</h2>
      <p class="hint">{t.announcements_lead}</p>
      <RoleGate roles={["dispatcher"]}>
        <AnnouncementForm />
      </RoleGate>
      {announcements.problem.value !== null && (
        <ProblemAlert problem={announcements.problem.value} />
      )}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_announcements}</p>}
      <ul class="rows">
        {(shown ?? []).map((one) => (
          <li key={one.announcement_id} data-announcement={one.announcement_id}>
            <AnnouncementRow one={one} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function AnnouncementRow({ one }: { readonly one: Announcement }) {
  const t = texts.value;
  const [first, second] =
    language.value === "en" ? [one.text_en, one.text_zh] : [one.text_zh, one.text_en];
  return (
    <div class="line">
      <span>
        <strong>{first}</strong> {second}
        <small>
          <span class={`chip ${TONES[one.state]}`}>{t.announcement_states[one.state]}</span>{" "}
          {addresseesOf(one)} · {timesOf(one)} · {one.made_by}
          {one.ended_at !== null &&
            ` · ${t.announcement_ended_by(one.ended_by, formatDateTime(one.ended_at))}`}
        </small>
      </span>
      {one.state !== "over" && (
        <RoleGate roles={["dispatcher"]}>
          <EndButton one={one} />
        </RoleGate>
      )}
    </div>
  );
}

function EndButton({ one }: { readonly one: Announcement }) {
  const problem = useSignal<Problem | null>(null);
  const end = async () => {
    const result = await resultOf(
      api.POST("/api/v1/announcements/{announcement_id}/end", {
        params: { path: { announcement_id: one.announcement_id } },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    await announcements.refresh();
  };
  return (
    <>
      <button type="button" class="button small" onClick={() => void end()}>
        {texts.value.end_announcement}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </>
  );
}
