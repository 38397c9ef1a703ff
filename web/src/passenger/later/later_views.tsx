import { signal } from "@preact/signals";
import { Alert, Loading } from "../../shared/ui/alerts";
import { texts } from "../texts/texts";

type Views = typeof import("./views");

/** The code of all views but the booking form; null until it has come. */
export const laterViews = signal<Views | null>(null);

const is_missing = signal(false);

/** The form needs none of it, so that it can come afterwards; a link to a ride needs it at once. */
export async function loadLaterViews(): Promise<void> {
  if (laterViews.peek() !== null) return;
  is_missing.value = false;
  try {
    const views = await import("./views");
    laterViews.value = views;
    views.deliverKeptCancels();
  } catch (error) {
    console.info("the code of the views did not come", error);
    is_missing.value = true;
  }
}

/** In the place of a view whose code has not come. A tab of an older server finds its files after a reload only. */
export function LaterViewWaiting() {
  const t = texts.value;
  if (!is_missing.value) return <Loading text={t.loading_view} />;
  return (
    <section class="ride">
      <Alert tone="warning">{t.view_failed}</Alert>
      <button type="button" class="button main" onClick={() => location.reload()}>
        {t.reload}
      </button>
    </section>
  );
}
