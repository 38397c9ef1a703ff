import { useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import { second } from "../../shared/live/clock";
import type { Scene } from "../../shared/scene/scene";
import { Loading, Note } from "../../shared/ui/alerts";
import { IncidentList } from "../incidents/incident_list";
import { SceneMap } from "../map/scene_map";
import { goTo, place } from "../navigation";
import { link } from "../session";
import { closures, incidents } from "../store/lists";
import { texts } from "../texts/texts";
import { VehiclePanel } from "../vehicles/vehicle_panel";
import { VehicleList } from "./vehicle_list";

const INCIDENTS_SHOWN = 4;

export function LivePage({ campus }: { readonly campus: Campus }) {
  const scene = useComputed(() => link.value?.scene.value ?? null);
  const chosen = place.value.parts[0] ?? "";
  useEffect(() => {
    void closures.refresh();
  }, []);
  return (
    <div class="live">
      <SceneMap
        campus={campus}
        scene={scene.value}
        chosen={chosen}
        still={false}
        at_ms={second.value > 0 ? (link.value?.now_ms() ?? undefined) : undefined}
        closures={closures.value.value ?? []}
        onChoose={(vehicle_id) => goTo("live", vehicle_id)}
      />
      <aside class="side">
        {scene.value === null ? <LinkState /> : <Side scene={scene.value} chosen={chosen} />}
      </aside>
    </div>
  );
}

function Side({ scene, chosen }: { readonly scene: Scene; readonly chosen: string }) {
  const vehicle = scene.vehicles.find((candidate) => candidate.vehicle_id === chosen);
  const now_ms = second.value > 0 ? (link.value?.now_ms() ?? scene.at_ms) : scene.at_ms;
  if (vehicle !== undefined)
    return <VehiclePanel key={chosen} vehicle={vehicle} scene={scene} now_ms={now_ms} />;
  const open = (incidents.value.value ?? []).filter((incident) => incident.closed_at === null);
  return (
    <>
      {open.length > 0 && (
        <section class="block" aria-label={texts.value.incidents}>
          <h2>{texts.value.incidents}</h2>
          <IncidentList shown={open.slice(0, INCIDENTS_SHOWN)} />
        </section>
      )}
      <VehicleList scene={scene} />
    </>
  );
}

function LinkState() {
  const refusal = link.value?.refusal.value ?? null;
  if (refusal !== null) return <Note tone="danger">{refusal.detail}</Note>;
  return <Loading text={texts.value.link_connecting} />;
}
