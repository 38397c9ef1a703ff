import { RoleGate } from "../account/role_gate";
import type { Scene, VehicleScene } from "../../shared/scene/scene";
import { BackIcon } from "../../shared/ui/icons";
import { goTo } from "../navigation";
import { knowledge } from "../session";
import { texts } from "../texts/texts";
import { ConditionChip } from "./condition_chip";
import { PositionPanel } from "./position_panel";
import { RecordingPanel } from "./recording_panel";
import { CameraPanel } from "./camera_panel";
import { ScenePanel } from "./scene_panel";
import { ShiftForm } from "./shift_form";
import { VehicleCommands } from "./vehicle_commands";
import { VehicleStatus } from "./vehicle_status";
import { VisitList } from "./visit_list";

interface VehiclePanelProps {
  readonly vehicle: VehicleScene;
  readonly scene: Scene;
  readonly now_ms: number;
}

/** A live shuttle: commands, status, visits ahead and shifts. */
export function VehiclePanel({ vehicle, scene, now_ms }: VehiclePanelProps) {
  const t = texts.value;
  return (
    <section class="block vehicle" aria-label={vehicle.facts.name}>
      <header class="block-head">
        <button type="button" class="button quiet small" onClick={() => goTo("live")}>
          <BackIcon />
          {t.all_vehicles}
        </button>
      </header>
      <div class="row-head">
        <h2>{vehicle.facts.name}</h2>
        <ConditionChip vehicle={vehicle} knowledge={knowledge.value} />
        {!vehicle.facts.in_service && <span class="chip warning">{t.out_of_service}</span>}
      </div>
      <VehicleCommands vehicle={vehicle} scene={scene} />
      <RecordingPanel key={vehicle.vehicle_id} vehicle={vehicle} />
      <CameraPanel key={`${vehicle.vehicle_id} camera`} vehicle={vehicle} />
      <ScenePanel key={`${vehicle.vehicle_id} scene`} vehicle={vehicle} />
      <PositionPanel key={`${vehicle.vehicle_id} position`} vehicle={vehicle} />
      <VehicleStatus vehicle={vehicle} scene={scene} knowledge={{ ...knowledge.value, now_ms }} />
      <VisitList vehicle={vehicle} />
      <RoleGate roles={["dispatcher"]}>
        <ShiftForm vehicle_id={vehicle.vehicle_id} />
      </RoleGate>
    </section>
  );
}
