import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Schemas } from "../../shared/api/client";
import { api, resultOf } from "../../shared/api/client";
import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";
import { RoleGate } from "../account/role_gate";
import { mapProposals, scanRequests } from "../store/scans";
import { texts } from "../texts/texts";
import { formatDateTime } from "../texts/times";
import { ScanRequestForm } from "./scan_request_form";

const REFRESH_MS = 5_000;

/** Requests for scans, and what came from which shuttle. */
export function ScanRequests() {
  const t = texts.value;
  const shown = scanRequests.value.value;
  useEffect(() => {
    void scanRequests.refresh();
    const timer = window.setInterval(() => void scanRequests.refresh(), REFRESH_MS);
    return () => window.clearInterval(timer);
  }, []);
  return (
    <section class="block card">
      <h2>{t.scans}</h2>
      <p class="hint">{t.scans_lead}</p>
      <RoleGate roles={["dispatcher", "safety"]}>
        <ScanRequestForm />
      </RoleGate>
      {scanRequests.problem.value !== null && <ProblemAlert problem={scanRequests.problem.value} />}
      {shown !== null && shown.length === 0 && <p class="empty">{t.no_scan_requests}</p>}
      <ul class="rows">
        {(shown ?? []).map((request) => (
          <li key={request.request_id}>
            <RequestRow request={request} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function RequestRow({ request }: { readonly request: Schemas["ScanRequestView"] }) {
  const t = texts.value;
  const problem = useSignal<Problem | null>(null);
  const params = { path: { request_id: request.request_id } };
  const end = async () => {
    const result = await resultOf(api.POST("/api/v1/scan-requests/{request_id}/end", { params }));
    problem.value = result.ok ? null : result.problem;
    await scanRequests.refresh();
  };
  const make = async () => {
    const result = await resultOf(api.POST("/api/v1/scan-requests/{request_id}/maps", { params }));
    problem.value = result.ok ? null : result.problem;
    await mapProposals.refresh();
  };
  return (
    <div class="line">
      <span>
        <strong>{request.name}</strong>{" "}
        <span class={`chip ${request.state === "open" ? "good" : ""}`}>
          {t.scan_request_states[request.state]}
        </span>
        <small>
          {t.scan_request_asked(request.started_by, formatDateTime(request.started_at))}
        </small>
        <small>
          {t.scan_received(
            request.scans,
            request.way_m.toFixed(0),
            (request.size_bytes / 1e6).toFixed(1),
          )}
        </small>
        {request.vehicles.map((vehicle) => (
          <small key={vehicle.vehicle_id}>
            {t.scan_vehicle(
              vehicle.vehicle_id,
              t.scan_vehicle_states[vehicle.state],
              vehicle.scans,
              vehicle.way_m.toFixed(0),
            )}
            {vehicle.detail !== "" && ` (${vehicle.detail})`}
          </small>
        ))}
      </span>
      <RoleGate roles={["dispatcher", "safety"]}>
        {request.state === "open" && (
          <button type="button" class="button small" onClick={() => void end()}>
            {t.scan_end}
          </button>
        )}
        {request.scans > 0 && (
          <button type="button" class="button small" onClick={() => void make()}>
            {t.scan_make_map}
          </button>
        )}
      </RoleGate>
      {problem.value !== null && <ProblemAlert problem={problem.value} />}
    </div>
  );
}
