import { useComputed } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Campus } from "../../shared/campus/campus";
import { monotonic_ms } from "../../shared/live/clock";
import type { Scene } from "../../shared/scene/scene";
import { Alert, Loading } from "../../shared/ui/alerts";
import { VehicleList } from "../fleet/vehicle_list";
import { IncidentList } from "../incidents/incident_list";
import { SceneMap } from "../map/scene_map";
import { address, goTo } from "../navigation";
import { live_onboard } from "../onboard/shown_scene";
import { age_s, is_stale, link } from "../session";
import { closures } from "../store/closures";
import { incidents } from "../store/incidents";
import { texts } from "../texts/texts";
import { afterClick, position_choice } from "../vehicles/position_choice";
import { VehiclePanel } from "../vehicles/vehicle_panel";

const INCIDENTS_SHOWN = 4;

export function LivePage({ campus }: { readonly campus: Campus }) {
  const scene = useComputed(() => link.value?.scene.value ?? null);
  const selected_id = address.value.ids[0] ?? "";
  useEffect(() => {
    void closures.refresh();
  }, []);
  return (
    <div class={is_stale.value ? "live stale" : "live"} data-stale={is_stale.value || undefined}>
      <h1 class="visually-hidden">{texts.value.live}</h1>
      <SceneMap
        campus={campus}
        scene={scene.value}
        selected_vehicle={selected_id}
        interpolate
        at_ms={monotonic_ms.value > 0 ? (link.value?.now_ms() ?? undefined) : undefined}
        closures={closures.value.value ?? []}
        onboard={live_onboard.value?.present ?? null}
        choice={position_choice.value}
        onGround={(at) => {
          if (position_choice.value !== null)
            position_choice.value = afterClick(position_choice.value, at);
        }}
        onSelect={(vehicle_id) => goTo("live", vehicle_id)}
      />
      <aside class="side">
        {is_stale.value && <Alert tone="warning">{texts.value.not_live(age_s.value)}</Alert>}
        {scene.value === null ? (
          <MissingScene />
        ) : (
          <SidePanel scene={scene.value} selected_id={selected_id} />
        )}
      </aside>
    </div>
  );
}

interface SidePanelProps {
  readonly scene: Scene;
  readonly selected_id: string;
}

function SidePanel({ scene, selected_id }: SidePanelProps) {
  const vehicle = scene.vehicles.find((candidate) => candidate.vehicle_id === selected_id);
  const now_ms = monotonic_ms.value > 0 ? (link.value?.now_ms() ?? scene.at_ms) : scene.at_ms;
  if (vehicle !== undefined)
    return <VehiclePanel key={selected_id} vehicle={vehicle} scene={scene} now_ms={now_ms} />;
  const open = (incidents.value.value ?? []).filter((incident) => incident.closed_at === null);
  return (
    <>
      {open.length > 0 && (
        <section class="block" aria-label={texts.value.incidents}>
          <h2>{texts.value.incidents}</h2>
          <IncidentList shown={open.slice(0, INCIDENTS_SHOWN)} heading="h3" />
        </section>
      )}
      <VehicleList scene={scene} />
    </>
  );
}

function MissingScene() {
  const refusal = link.value?.refusal.value ?? null;
  if (refusal !== null) return <Alert tone="danger">{refusal.detail}</Alert>;
  return <Loading text={texts.value.link_connecting} />;
}
