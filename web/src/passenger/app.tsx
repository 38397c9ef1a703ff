import { useSignalEffect } from "@preact/signals";
import type { Campus } from "./campus/campus";
import { campus, campusProblem, loadCampus } from "./campus/campus";
import { Alert, Loading, ProblemAlert } from "../shared/ui/alerts";
import { Logo } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { BookingPanel } from "./booking/booking_panel";
import { OfflineNotice } from "./offline";
import { address, goTo } from "./navigation";
import { LaterViewWaiting, laterViews, loadLaterViews } from "./later/later_views";
import { MapArea } from "./map/map_area";
import { title_prefix } from "./page_title";
import { trackedRide } from "./ride/tracked_ride";
import { isLanguageMissing, switchLanguage, texts } from "./texts/texts";
import { removeRideToken } from "./token_storage";

export function App() {
  useSignalEffect(() => {
    const { title } = texts.value;
    document.title = title_prefix.value === "" ? title : `${title_prefix.value} · ${title}`;
  });
  useSignalEffect(() => {
    laterViews.value?.trackRide(address.value.view === "ride" ? address.value.token : null);
  });
  useSignalEffect(() => {
    if (address.value.view !== "book") void loadLaterViews();
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
  const [ride, views] = [trackedRide.value, laterViews.value];
  const has_help = ride?.progress.value?.ended === false;
  return (
    <>
      <a class="skip" href="#panel" onClick={skipToPanel}>
        {texts.value.skip_to_panel}
      </a>
      <header class="top">
        <Logo />
        <strong>{texts.value.title}</strong>
        <LanguageSwitch onChoose={(choice) => void switchLanguage(choice)} />
        {has_help && views !== null && <views.HelpButton ride={ride} />}
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
  const [ride, views] = [trackedRide.value, laterViews.value];
  const { timezone } = campus.view;
  return (
    <div class={`page view-${address.value.view}`}>
      <MapArea campus={campus} />
      <div class="panel" id="panel" tabIndex={-1}>
        <OfflineNotice timezone={timezone} />
        {isLanguageMissing.value && <Alert tone="warning">{texts.value.language_failed}</Alert>}
        {ride !== null && views !== null && <views.HelpReceipt ride={ride} timezone={timezone} />}
        <Panel campus={campus} />
      </div>
    </div>
  );
}

function Panel({ campus }: { readonly campus: Campus }) {
  const [ride, views, shown] = [trackedRide.value, laterViews.value, address.value];
  if (shown.view === "book") return <BookingPanel campus={campus} />;
  if (shown.view === "broken_link") return <BrokenLink />;
  if (views === null) return <LaterViewWaiting />;
  switch (shown.view) {
    case "ride":
      return ride === null ? <LaterViewWaiting /> : <views.RidePanel ride={ride} campus={campus} />;
    case "series":
      return <views.SeriesPanel token={shown.token} campus={campus} />;
    case "timetable":
      return <views.TimetablePanel campus={campus} />;
    case "find":
      return <views.RideLookupPanel code={shown.code} campus={campus} />;
  }
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
