import { effect, signal } from "@preact/signals";
import { api } from "../shared/api/client";
import { STORED_AT } from "../shared/api/server_time";
import { language } from "../shared/texts/language";
import { formatTimeOrDateTime } from "../shared/texts/times";
import { Alert } from "../shared/ui/alerts";
import { loadCampus } from "./campus/campus";
import { texts } from "./texts/texts";

/** When what the page shows was stored on this phone; null while the server answers. */
export const stored_at = signal<string | null>(null);

/** A connection that the browser reports may not carry anything yet. */
const RETRY_MS = 4_000;

/** Keeps the page, the timetable and the last ticket on this phone, for when there is no connection. */
export function keepForOffline(): void {
  api.use({
    onResponse: ({ request, response }) => {
      if (request.method === "GET") stored_at.value = response.headers.get(STORED_AT);
    },
  });
  window.addEventListener("online", () => {
    if (stored_at.value !== null) void loadCampus();
  });
  effect(() => {
    if (stored_at.value === null) return undefined;
    const timer = window.setInterval(() => void loadCampus(), RETRY_MS);
    return () => clearInterval(timer);
  });
  // Browsers have no service workers on a plain address of the local network.
  if ("serviceWorker" in navigator) void navigator.serviceWorker.register("/sw.js");
}

/** Says that what is shown is a copy, and of when. */
export function OfflineNotice({ timezone }: { readonly timezone: string }) {
  if (stored_at.value === null) return null;
  const time = formatTimeOrDateTime(stored_at.value, Date.now(), language.value, timezone);
  return (
    <div class="offline" data-offline>
      <Alert tone="warning">{texts.value.offline_copy(time)}</Alert>
    </div>
  );
}
