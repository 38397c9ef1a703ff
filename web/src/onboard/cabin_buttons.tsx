import { useState } from "preact/hooks";
import { ConfirmDialog, Dialog } from "../shared/ui/dialog";
import { CodeDialog } from "./code_dialog";
import { DestinationDialog } from "./destination_dialog";
import type { ScreenLink } from "./screen_link";
import type { CabinView, ScreenRequest } from "./screen_scene";
import { texts } from "./texts/texts";

interface CabinButtonsProps {
  readonly link: ScreenLink;
  readonly view: CabinView | null;
  readonly stops: readonly { stop_id: string; name: string; name_en: string }[];
}

type Open = "none" | "seats" | "destination" | "code" | "help";

/** What a passenger can ask for. Each does what a button or the keypad in the cabin does. */
export function CabinButtons({ link, view, stops }: CabinButtonsProps) {
  const t = texts.value;
  const [open, setOpen] = useState<Open>("none");
  const [not_sent, setNotSent] = useState(false);
  const close = () => setOpen("none");
  const send = (request: ScreenRequest) => {
    setNotSent(!link.send(request));
    close();
  };
  const seats = link.scene.value?.seats ?? 0;
  return (
    <section class="actions">
      <button type="button" class="button" onClick={() => setOpen("seats")} disabled={seats === 0}>
        {t.get_off}
      </button>
      <button
        type="button"
        class="button"
        onClick={() => setOpen("destination")}
        disabled={(view?.parties ?? 0) === 0 || stops.length === 0}
      >
        {t.destination}
      </button>
      <button type="button" class="button" onClick={() => setOpen("code")}>
        {t.code}
      </button>
      <button type="button" class="button danger main" onClick={() => setOpen("help")}>
        {t.help}
      </button>
      {not_sent && (
        <p class="not-sent" role="alert">
          {t.not_sent}
        </p>
      )}
      {open === "seats" && (
        <Dialog title={t.get_off} onClose={close}>
          <p>{t.get_off_lead}</p>
          <div class="seat-grid">
            {Array.from({ length: seats }, (_, index) => index + 1).map((seat) => (
              <button
                key={seat}
                type="button"
                class="button"
                onClick={() => send({ type: "stop", seat })}
              >
                {t.seat(seat)}
              </button>
            ))}
          </div>
          <button type="button" class="button" onClick={close}>
            {t.close}
          </button>
        </Dialog>
      )}
      {open === "destination" && (
        <DestinationDialog
          stops={stops}
          needs_code={view?.parties !== 1}
          onChoose={(stop_id, code) => send({ type: "destination", stop_id, code })}
          onClose={close}
        />
      )}
      {open === "code" && (
        <CodeDialog
          title={t.code}
          lead={t.code_lead}
          onCode={(code) => send({ type: "code", code })}
          onClose={close}
        />
      )}
      {open === "help" && (
        <ConfirmDialog
          title={t.help_title}
          text={t.help_lead}
          yes={t.help_yes}
          no={t.close}
          danger
          onYes={() => send({ type: "help" })}
          onNo={close}
        />
      )}
    </section>
  );
}
