import { useSignal } from "@preact/signals";
import { useMemo } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { Alert, ProblemAlert } from "../../shared/ui/alerts";
import { Dialog } from "../../shared/ui/dialog";
import { texts } from "../texts/texts";
import type { AnnouncementBody } from "./announcement_draft";
import { addresseesOf, timesOf } from "./announcement_text";

interface AnnouncementPreviewProps {
  readonly body: AnnouncementBody;
  readonly onMade: () => void;
  readonly onClose: () => void;
}

/** The announcement as riders will read it, to whom and for how long, before it goes out. */
export function AnnouncementPreview({ body, onMade, onClose }: AnnouncementPreviewProps) {
  const t = texts.value;
  const is_sending = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  // One wish: a second click, or one more try after a lost answer, announces nothing twice.
  const key = useMemo(() => crypto.randomUUID(), [body]);
  const make = async () => {
    is_sending.value = true;
    const result = await resultOf(
      api.POST("/api/v1/announcements", {
        body,
        params: { header: { "idempotency-key": key } },
      }),
    );
    is_sending.value = false;
    problem.value = result.ok ? null : result.problem;
    if (result.ok) onMade();
  };
  return (
    <Dialog title={t.announcement_preview_title} onClose={onClose}>
      <h3>{t.on_a_board}</h3>
      <div lang="zh-CN" data-preview="zh">
        <Alert>{body.text_zh}</Alert>
      </div>
      <div lang="en" data-preview="en">
        <Alert>{body.text_en}</Alert>
      </div>
      <p>
        {addresseesOf(body)} · {timesOf(body)}
      </p>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onClose}>
          {t.cancel}
        </button>
        <button
          type="button"
          class="button main"
          disabled={is_sending.value}
          onClick={() => void make()}
        >
          {t.publish_announcement}
        </button>
      </div>
    </Dialog>
  );
}
