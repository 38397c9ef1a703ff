import { useSignalEffect } from "@preact/signals";
import type { Campus } from "./campus/campus";
import { campus, campusProblem, loadCampus } from "./campus/campus";
import { Alert, Loading, ProblemAlert } from "../shared/ui/alerts";
import { Logo } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { BookingPanel } from "./booking/booking_panel";
import { OfflineNotice } from "./offline";
import { address, goTo } from "./navigation";
import { MapArea } from "./map/map_area";
import { HelpButton, HelpReceipt } from "./ride/help_call";
import { RideLookupPanel } from "./ride/ride_lookup_panel";
import { RidePanel } from "./ride/ride_panel";
import { trackRide, trackedRide } from "./ride/ride_tracker";
import { SeriesPanel } from "./series/series_panel";
import { texts } from "./texts/texts";
import { TimetablePanel } from "./timetable/timetable_panel";
import { removeRideToken } from "./token_storage";

export function App() {
  useSignalEffect(() => {
    document.title = texts.value.title;
  });
  useSignalEffect(() => {
    trackRide(address.value.view === "ride" ? address.value.token : null);
  });
  useSignalEffect(() => {
    const ride = trackedRide.value;
    if (ride?.progress.value?.ended === true) removeRideToken(ride.token);
  });
  useSignalEffect(() => {
    const drawn = campus.peek()?.view.map_version;
    const needed = trackedRide.value?.link.scene.value?.map_version;
    if (drawn !== undefined && needed !== undefined && needed !== drawn) void loadCampus();
  });
  const ride = trackedRide.value;
  const has_help = ride?.progress.value?.ended === false;
  return (
    <>
      <a class="skip" href="#panel" onClick={skipToPanel}>
        {texts.value.skip_to_panel}
      </a>
      <header class="top">
        <Logo />
        <strong>{texts.value.title}</strong>
        <LanguageSwitch />
        {has_help && <HelpButton ride={ride} />}
      </header>
      <main>{campus.value === null ? <CampusLoading /> : <Page campus={campus.value} />}</main>
    </>
  );
}

/** Moves the focus to the panel. A plain anchor would change the fragment, which holds the page's address. */
function skipToPanel(event: Event): void {
  event.preventDefault();
  document.getElementById("panel")?.focus();
}

function Page({ campus }: { readonly campus: Campus }) {
  const ride = trackedRide.value;
  const shown = address.value;
  return (
    <div class={`page view-${shown.view}`}>
      <MapArea campus={campus} />
      <div class="panel" id="panel" tabIndex={-1}>
        <OfflineNotice timezone={campus.view.timezone} />
        {ride !== null && <HelpReceipt ride={ride} timezone={campus.view.timezone} />}
        {ride !== null ? (
          <RidePanel ride={ride} campus={campus} />
        ) : shown.view === "series" ? (
          <SeriesPanel token={shown.token} campus={campus} />
        ) : shown.view === "timetable" ? (
          <TimetablePanel campus={campus} />
        ) : shown.view === "find" ? (
          <RideLookupPanel code={shown.code} campus={campus} />
        ) : shown.view === "broken_link" ? (
          <BrokenLink />
        ) : (
          <BookingPanel campus={campus} />
        )}
      </div>
    </div>
  );
}

function BrokenLink() {
  const t = texts.value;
  return (
    <section class="ride">
      <h1>{t.link_broken_title}</h1>
      <Alert tone="warning">{t.link_broken}</Alert>
      <button type="button" class="button main" onClick={() => goTo({ view: "find", code: "" })}>
        {t.have_code}
      </button>
      <button type="button" class="button" onClick={() => goTo({ view: "book" })}>
        {t.book_another}
      </button>
    </section>
  );
}

function CampusLoading() {
  const problem = campusProblem.value;
  if (problem === null) return <Loading text={texts.value.loading_campus} />;
  return (
    <div class="startup">
      <ProblemAlert problem={problem} />
      <button type="button" class="button main" onClick={() => void loadCampus()}>
        {texts.value.try_again}
      </button>
    </div>
  );
}
