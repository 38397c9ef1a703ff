import { serverNow_ms } from "../../shared/api/server_time";
import { useEffect } from "preact/hooks";
import { language } from "../../shared/texts/language";
import { formatTimeOrDateTime } from "../../shared/texts/times";
import { Alert } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";
import type { Journey } from "./current_announcements";
import { announcements, concerning, watchAnnouncements } from "./current_announcements";

interface AnnouncementListProps extends Journey {
  readonly timezone: string;
}

/** What the operators tell riders of this journey. */
export function AnnouncementList({ timezone, ...journey }: AnnouncementListProps) {
  useEffect(watchAnnouncements, []);
  const t = texts.value;
  return (
    <>
      {concerning(announcements.value, journey).map((one) => (
        <div key={one.announcement_id} data-announcement>
          <Alert>
            <strong>{t.operators_say}</strong> {language.value === "en" ? one.text_en : one.text_zh}{" "}
            {one.ends_at !== null && (
              <small>
                {t.said_until(
                  formatTimeOrDateTime(one.ends_at, serverNow_ms(), language.value, timezone),
                )}
              </small>
            )}
          </Alert>
        </div>
      ))}
    </>
  );
}
