import { useSignalEffect } from "@preact/signals";
import type { Campus } from "../shared/campus/campus";
import { campus, campusProblem, loadCampus } from "../shared/campus/campus";
import { Loading } from "../shared/ui/alerts";
import { AccessPage } from "./access/access_page";
import { PasswordChange } from "./account/password_change";
import { SecondFactorDialog } from "./account/second_factor_dialog";
import { fragmentOf } from "./address";
import { AuditPage } from "./audit/audit_page";
import { FailedLoad } from "./failed_load";
import { noteUnacknowledged } from "./incidents/incident_sound";
import { IncidentsPage } from "./incidents/incidents_page";
import { LivePage } from "./live/live_page";
import { EditorPage } from "./map_editor/editor_page";
import { MapsPage } from "./map_editor/maps_page";
import { address } from "./navigation";
import { CommandPalette } from "./palette/command_palette";
import { RidePage } from "./rides/ride_page";
import { RidesPage } from "./rides/rides_page";
import { FleetReplayPage } from "./runs/fleet/fleet_replay_page";
import { FLEET, fleetReplayOf } from "./runs/fleet/replay_address";
import { ReplayPage } from "./runs/replay_page";
import { RunsPage } from "./runs/runs_page";
import { ServicePage } from "./service/service_page";
import { link, restoreSession, session, sessionProblem } from "./session";
import { StatisticsPage } from "./statistics/statistics_page";
import { SignIn } from "./sign_in";
import { incidents } from "./store/incidents";
import { rides } from "./store/rides";
import { texts } from "./texts/texts";
import { TopBar } from "./top_bar";

export function App() {
  useSignalEffect(() => {
    const waiting = link.value?.scene.value?.incidents.unacknowledged ?? 0;
    document.title = waiting === 0 ? texts.value.title : texts.value.title_with_incidents(waiting);
  });
  if (session.value === null) return <SignIn />;
  if (session.value === undefined) return <SessionCheck />;
  if (session.value.password_change_needed) return <PasswordChange />;
  return <Console />;
}

function SessionCheck() {
  const problem = sessionProblem.value;
  if (problem === null) return <Loading text={texts.value.checking_session} />;
  return (
    <main class="sign-in">
      <FailedLoad problem={problem} onRetry={() => void restoreSession()} />
    </main>
  );
}

function Console() {
  useSignalEffect(() => {
    const serial = link.value?.scene.value?.incidents.serial;
    if (serial !== undefined) refreshIncidents(serial);
  });
  useSignalEffect(() => {
    const waiting = link.value?.scene.value?.incidents.unacknowledged;
    if (waiting !== undefined) noteUnacknowledged(waiting);
  });
  useSignalEffect(() => {
    const scene_rides = link.value?.scene.value?.rides;
    if (scene_rides !== undefined) refreshRides(scene_rides);
  });
  useSignalEffect(() => {
    const drawn = campus.peek()?.geometry.map_version;
    const needed = link.value?.scene.value?.map_version;
    if (drawn !== undefined && needed !== undefined && needed !== drawn) void loadCampus();
  });
  return (
    <div class="console">
      <TopBar />
      <HelpBanner />
      <SecondFactorDialog />
      <CommandPalette />
      <main>
        {campus.value === null ? <CampusLoading /> : <CurrentPage campus={campus.value} />}
      </main>
    </div>
  );
}

let last_serial = -1;
let last_rides: unknown = null;

/** The scene says only that incidents changed; the list itself comes from the API. */
function refreshIncidents(serial: number): void {
  if (serial === last_serial) return;
  last_serial = serial;
  void incidents.refresh();
}

function refreshRides(scene_rides: unknown): void {
  if (scene_rides === last_rides) return;
  last_rides = scene_rides;
  if (address.peek().page === "rides") void rides.refresh();
}

function CurrentPage({ campus: shown }: { readonly campus: Campus }) {
  const { page, ids } = address.value;
  const [first_id] = ids;
  switch (page) {
    case "rides":
      return ids[0] === undefined ? <RidesPage /> : <RidePage key={ids[0]} ride_id={ids[0]} />;
    case "service":
      return <ServicePage />;
    case "maps":
      return first_id === undefined ? (
        <MapsPage />
      ) : (
        <EditorPage key={first_id} campus={shown} draft_id={first_id} />
      );
    case "incidents":
      return <IncidentsPage />;
    case "runs":
      return <CurrentRun campus={shown} ids={ids} />;
    case "statistics":
      return <StatisticsPage campus={shown} />;
    case "audit":
      return <AuditPage />;
    case "access":
      return <AccessPage />;
    case "live":
      return <LivePage campus={shown} />;
  }
}

interface CurrentRunProps {
  readonly campus: Campus;
  readonly ids: readonly string[];
}

/** The list of runs, the replay of one, or that of the fleet. */
function CurrentRun({ campus: shown, ids }: CurrentRunProps) {
  const [vehicle_id, boot_id, at] = ids;
  if (vehicle_id === FLEET) {
    const replay = fleetReplayOf(ids);
    if (replay === null) return <RunsPage campus={shown} is_link_broken />;
    const key = `${replay.start_ms} ${replay.end_ms}`;
    return <FleetReplayPage key={key} campus={shown} replay={replay} />;
  }
  if (vehicle_id === undefined || boot_id === undefined) return <RunsPage campus={shown} />;
  const first_ms = Number.isSafeInteger(Number(at)) && at !== undefined ? Number(at) : null;
  return (
    <ReplayPage
      key={`${vehicle_id}/${boot_id}`}
      campus={shown}
      vehicle_id={vehicle_id}
      boot_id={boot_id}
      first_ms={first_ms}
    />
  );
}

/** Shown on every page until every help call is acknowledged. */
function HelpBanner() {
  const calls = link.value?.scene.value?.incidents.help_calls ?? 0;
  if (calls === 0) return null;
  const t = texts.value;
  return (
    <div class="help-banner" role="alert">
      <strong>{t.help_banner(calls)}</strong>
      <a class="button small" href={fragmentOf("incidents")}>
        {t.show_incidents}
      </a>
    </div>
  );
}

function CampusLoading() {
  const problem = campusProblem.value;
  if (problem === null) return <Loading text={texts.value.loading} />;
  return (
    <div class="sheet narrow">
      <FailedLoad problem={problem} onRetry={() => void loadCampus()} />
    </div>
  );
}
