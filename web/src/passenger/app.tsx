import { useSignalEffect } from "@preact/signals";
import type { Campus } from "../shared/campus/campus";
import { campus, campusProblem, loadCampus } from "../shared/campus/campus";
import { Loading, ProblemNote } from "../shared/ui/alerts";
import { LoopMark } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { BookingPanel } from "./booking/booking_panel";
import { address } from "./navigation";
import { Stage } from "./passenger_map";
import { HelpButton, HelpReceived } from "./ride/help_call";
import { CodePanel } from "./ride/ride_lookup_panel";
import { RidePanel } from "./ride/ride_panel";
import { follow, followed } from "./ride/ride_tracker";
import { SeriesPanel } from "./series/series_panel";
import { texts } from "./texts/texts";
import { TimetablePanel } from "./timetable/timetable_panel";
import { forgetRide } from "./token_storage";

export function App() {
  useSignalEffect(() => {
    document.title = texts.value.title;
  });
  useSignalEffect(() => {
    follow(address.value.view === "ride" ? address.value.token : null);
  });
  useSignalEffect(() => {
    const ride = followed.value;
    if (ride?.story.value?.ended === true) forgetRide(ride.token);
  });
  useSignalEffect(() => {
    const drawn = campus.peek()?.shape.map_version;
    const needed = followed.value?.link.scene.value?.map_version;
    if (drawn !== undefined && needed !== undefined && needed !== drawn) void loadCampus();
  });
  const ride = followed.value;
  const has_help = ride?.story.value?.ended === false;
  return (
    <>
      <a class="skip" href="#panel" onClick={skipToPanel}>
        {texts.value.skip_to_panel}
      </a>
      <header class="top">
        <LoopMark />
        <strong>{texts.value.title}</strong>
        <LanguageSwitch />
        {has_help && <HelpButton ride={ride} />}
      </header>
      <main>{campus.value === null ? <Starting /> : <Page campus={campus.value} />}</main>
    </>
  );
}

/** The fragment says which page this is, so a plain anchor would leave it. */
function skipToPanel(event: Event): void {
  event.preventDefault();
  document.getElementById("panel")?.focus();
}

function Page({ campus }: { readonly campus: Campus }) {
  const ride = followed.value;
  const here = address.value;
  return (
    <div class={`page view-${here.view}`}>
      <Stage campus={campus} />
      <div class="panel" id="panel" tabIndex={-1}>
        {ride !== null && <HelpReceived ride={ride} timezone={campus.view.timezone} />}
        {ride !== null ? (
          <RidePanel ride={ride} campus={campus} />
        ) : here.view === "series" ? (
          <SeriesPanel token={here.token} campus={campus} />
        ) : here.view === "timetable" ? (
          <TimetablePanel campus={campus} />
        ) : here.view === "find" ? (
          <CodePanel code={here.code} campus={campus} />
        ) : (
          <BookingPanel campus={campus} />
        )}
      </div>
    </div>
  );
}

function Starting() {
  const problem = campusProblem.value;
  if (problem === null) return <Loading text={texts.value.loading_campus} />;
  return (
    <div class="starting">
      <ProblemNote problem={problem} />
      <button type="button" class="button main" onClick={() => void loadCampus()}>
        {texts.value.try_again}
      </button>
    </div>
  );
}
