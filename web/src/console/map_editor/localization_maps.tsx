import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { ConfirmDialog } from "../../shared/ui/dialog";
import { RoleGate } from "../account/role_gate";
import { localizationMaps } from "../store/maps";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";

/** Vehicles change over one after the other. */
const REFRESH_MS = 5_000;

/** What vehicles compare their scans with: versions, which one is in force, and who uses which. */
export function LocalizationMaps() {
  const t = texts.value;
  const shown = localizationMaps.value.value;
  useEffect(() => {
    void localizationMaps.refresh();
    const timer = window.setInterval(() => void localizationMaps.refresh(), REFRESH_MS);
    return () => window.clearInterval(timer);
  }, []);
  return (
    <section class="block card">
      <h2>{t.localization_maps}</h2>
      <p class="hint">{t.localization_maps_lead}</p>
      {localizationMaps.problem.value !== null && (
        <ProblemAlert problem={localizationMaps.problem.value} />
      )}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_localization_maps}</p>}
      <ul class="rows">
        {(shown ?? []).map((version) => (
          <li key={version.map_version}>
            <VersionRow version={version} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function VersionRow({ version }: { readonly version: Schemas["LocalizationMapView"] }) {
  const t = texts.value;
  const asks = useSignal<"put" | "remove" | null>(null);
  const problem = useSignal<Problem | null>(null);
  const params = { path: { map_version: version.map_version } };
  const put = async () => {
    asks.value = null;
    const result = await resultOf(
      api.POST("/api/v1/localization-maps/{map_version}/activations", { params }),
    );
    problem.value = result.ok ? null : result.problem;
    await localizationMaps.refresh();
  };
  const remove = async () => {
    asks.value = null;
    const result = await resultOf(
      api.DELETE("/api/v1/localization-maps/{map_version}", { params }),
    );
    problem.value = result.ok ? null : result.problem;
    await localizationMaps.refresh();
  };
  return (
    <div class="line">
      <span>
        <strong>{version.note || version.map_version.slice(0, 12)}</strong>{" "}
        {version.active && <span class="chip good">{t.map_in_force}</span>}
        {!version.in_frame && <small>{t.localization_map_elsewhere}</small>}
        <small>
          {t.localization_map_kinds[version.kind]} ·{" "}
          {t.localization_map_size(version.tile_count, (version.size_bytes / 1e6).toFixed(1))}
        </small>
        <small>
          {t.localization_map_published(
            version.published_by,
            formatDateTime(version.published_at),
            version.map_version.slice(0, 12),
          )}
        </small>
        {version.active && version.activated_at !== null && (
          <small>
            {t.localization_map_activated(
              version.activated_by,
              formatDateTime(version.activated_at),
            )}
          </small>
        )}
        {version.used_by.length > 0 && (
          <small>{t.localization_map_used_by(version.used_by.join(", "))}</small>
        )}
        {version.awaited.map((one) => (
          <small key={one.vehicle_id}>
            {t.localization_map_awaited(
              one.vehicle_id,
              t.localization_map_changes[one.change] ?? one.change,
            )}
          </small>
        ))}
      </span>
      {!version.active && (
        <RoleGate roles={["safety"]}>
          <div class="buttons">
            <button type="button" class="button small" onClick={() => (asks.value = "put")}>
              {t.put_in_force}
            </button>
            <button type="button" class="button small" onClick={() => (asks.value = "remove")}>
              {t.remove_localization_map}
            </button>
          </div>
        </RoleGate>
      )}
      {asks.value === "put" && (
        <ConfirmDialog
          title={t.put_in_force}
          text={t.put_localization_map_text}
          yes={t.put_in_force}
          no={t.cancel}
          onYes={() => void put()}
          onNo={() => (asks.value = null)}
        />
      )}
      {asks.value === "remove" && (
        <ConfirmDialog
          title={t.remove_localization_map}
          text={t.remove_localization_map_text}
          yes={t.remove_localization_map}
          no={t.cancel}
          danger
          onYes={() => void remove()}
          onNo={() => (asks.value = null)}
        />
      )}
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}
