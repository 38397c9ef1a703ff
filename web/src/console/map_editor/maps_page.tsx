import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { RoleGate } from "../account/role_gate";
import { fragmentOf } from "../address";
import { goTo } from "../navigation";
import { MapProposals } from "../scans/map_proposals";
import { ScanRequests } from "../scans/scan_requests";
import { mapDrafts, mapVersions } from "../store/maps";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { ImportForm } from "./import_form";
import { LocalizationMaps } from "./localization_maps";
import { MapProblemAlert } from "./map_problem_alert";

const FORMATS = ["geojson", "lanelet2", "map"] as const;

/** Versions of the map, the drafts that are drawn, localization maps, and the scans that new ones are made of. */
export function MapsPage() {
  const t = texts.value;
  useEffect(() => {
    void mapVersions.refresh();
    void mapDrafts.refresh();
  }, []);
  return (
    <section class="sheet">
      <header class="sheet-head">
        <h1>{t.maps}</h1>
      </header>
      <div class="service-grid">
        <section class="block card">
          <h2>{t.map_drafts}</h2>
          <p class="hint">{t.map_drafts_lead}</p>
          <RoleGate roles={["dispatcher", "safety"]}>
            <NewDraft />
            <ImportForm />
          </RoleGate>
          <DraftList />
        </section>
        <section class="block card">
          <h2>{t.map_versions}</h2>
          <p class="hint">{t.map_versions_lead}</p>
          <VersionList />
        </section>
        <LocalizationMaps />
        <ScanRequests />
        <MapProposals />
      </div>
    </section>
  );
}

function NewDraft() {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const make = async () => {
    const name = mapVersions.value.value?.find((version) => version.active)?.name ?? "";
    const result = await resultOf(
      api.POST("/api/v1/maps/drafts", { body: { name, map_version: null } }),
    );
    if (result.ok) goTo("maps", result.value.draft_id);
    else problem.value = result.problem;
  };
  return (
    <>
      <button type="button" class="button main" onClick={() => void make()}>
        {t.draw_on_current_map}
      </button>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </>
  );
}

function DraftList() {
  const t = texts.value;
  const shown = mapDrafts.value.value;
  return (
    <>
      {mapDrafts.problem.value !== null && <ProblemAlert problem={mapDrafts.problem.value} />}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_map_drafts}</p>}
      <ul class="rows">
        {(shown ?? []).map((draft) => (
          <li key={draft.draft_id}>
            <div class="line">
              <span>
                <a href={fragmentOf("maps", draft.draft_id)}>
                  <strong>{draft.name}</strong>
                </a>
                <small>{t.draft_changed(draft.changed_by, formatDateTime(draft.changed_at))}</small>
              </span>
            </div>
          </li>
        ))}
      </ul>
    </>
  );
}

function VersionList() {
  const shown = mapVersions.value.value;
  return (
    <>
      {mapVersions.problem.value !== null && <ProblemAlert problem={mapVersions.problem.value} />}
      <ul class="rows">
        {(shown ?? []).map((version) => (
          <li key={version.map_version}>
            <VersionRow version={version} />
          </li>
        ))}
      </ul>
    </>
  );
}

function VersionRow({ version }: { readonly version: Schemas["MapVersionView"] }) {
  const t = texts.value;
  const asks = useSignal(false);
  const problem = useSignal<Problem | null>(null);
  const put = async () => {
    asks.value = false;
    const result = await resultOf(
      api.POST("/api/v1/maps/{map_version}/activations", {
        params: { path: { map_version: version.map_version } },
      }),
    );
    problem.value = result.ok ? null : result.problem;
    await mapVersions.refresh();
  };
  return (
    <div class="line">
      <span>
        <strong>{version.name}</strong>{" "}
        {version.active && <span class="chip good">{t.map_in_force}</span>}
        <small>
          {formatDateTime(version.added_at)} · {version.map_version}
        </small>
        <small class="exports">
          {FORMATS.map((kind) => (
            <a key={kind} href={`/api/v1/maps/${version.map_version}/exports/${kind}`} download>
              {t.export_as(t.map_formats[kind])}
            </a>
          ))}
        </small>
      </span>
      {!version.active && (
        <RoleGate roles={["safety"]}>
          <button type="button" class="button small" onClick={() => (asks.value = true)}>
            {t.put_in_force}
          </button>
        </RoleGate>
      )}
      {asks.value && (
        <ConfirmDialog
          title={t.put_in_force}
          text={t.put_in_force_text}
          yes={t.put_in_force}
          no={t.cancel}
          onYes={() => void put()}
          onNo={() => (asks.value = false)}
        />
      )}
      {problem.value !== null && <MapProblemAlert problem={problem.value} />}
    </div>
  );
}
