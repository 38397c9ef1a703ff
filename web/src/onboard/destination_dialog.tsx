import { useState } from "preact/hooks";
import { language } from "../shared/texts/language";
import { Dialog } from "../shared/ui/dialog";
import { CodeDialog } from "./code_dialog";
import { texts } from "./texts/texts";

/** As many as fit on the smallest screen without scrolling. */
const STOPS_A_PAGE = 6;

type Stop = { readonly stop_id: string; readonly name: string; readonly name_en: string };

interface DestinationDialogProps {
  readonly stops: readonly Stop[];
  /** Several parties are aboard: the code says which one goes elsewhere. */
  readonly needs_code: boolean;
  readonly onChoose: (stop_id: string, code: string) => void;
  readonly onClose: () => void;
}

export function DestinationDialog({
  stops,
  needs_code,
  onChoose,
  onClose,
}: DestinationDialogProps) {
  const t = texts.value;
  const [page, setPage] = useState(0);
  const [chosen, setChosen] = useState<Stop | null>(null);
  const sorted = [...stops].sort((a, b) => nameOf(a).localeCompare(nameOf(b), language.value));
  const pages = Math.max(1, Math.ceil(sorted.length / STOPS_A_PAGE));
  if (chosen !== null)
    return (
      <CodeDialog
        title={t.code}
        lead={t.code_for(nameOf(chosen))}
        onCode={(code) => onChoose(chosen.stop_id, code)}
        onClose={onClose}
      />
    );
  return (
    <Dialog title={t.destination} onClose={onClose}>
      <p>{t.destination_lead}</p>
      <div class="stop-grid">
        {sorted.slice(page * STOPS_A_PAGE, (page + 1) * STOPS_A_PAGE).map((stop) => (
          <button
            key={stop.stop_id}
            type="button"
            class="button"
            onClick={() => (needs_code ? setChosen(stop) : onChoose(stop.stop_id, ""))}
          >
            {nameOf(stop)}
          </button>
        ))}
      </div>
      <div class="dialog-buttons">
        <button
          type="button"
          class="button"
          disabled={page === 0}
          onClick={() => setPage(page - 1)}
        >
          {t.earlier}
        </button>
        <span>{t.page_of(page + 1, pages)}</span>
        <button
          type="button"
          class="button"
          disabled={page + 1 >= pages}
          onClick={() => setPage(page + 1)}
        >
          {t.later}
        </button>
        <button type="button" class="button" onClick={onClose}>
          {t.close}
        </button>
      </div>
    </Dialog>
  );
}

function nameOf(stop: Stop): string {
  return language.value === "en" ? stop.name_en || stop.name : stop.name || stop.name_en;
}
