import type { VehicleScene } from "../../shared/scene/scene";
import { Dialog } from "../../shared/ui/dialog";
import { texts } from "../texts/texts";
import { CameraLook } from "./camera_panel";

interface WaveOnDialogProps {
  readonly vehicle: VehicleScene;
  readonly onYes: () => void;
  readonly onNo: () => void;
}

/** A look through the cameras before a shuttle is told that the person it waits for has gone. */
export function WaveOnDialog({ vehicle, onYes, onNo }: WaveOnDialogProps) {
  const t = texts.value;
  return (
    <Dialog title={t.wave_on_title(vehicle.facts.name)} onClose={onNo}>
      <p>{t.wave_on_text}</p>
      <CameraLook vehicle={vehicle} at_once />
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onNo}>
          {t.cancel}
        </button>
        <button type="button" class="button main" onClick={onYes}>
          {t.resume}
        </button>
      </div>
    </Dialog>
  );
}
