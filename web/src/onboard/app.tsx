import { useComputed, useSignal, useSignalEffect } from "@preact/signals";
import { language } from "../shared/texts/language";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { AnnouncementBar } from "./announcement_bar";
import { CabinButtons } from "./cabin_buttons";
import { DrivingFacts } from "./driving_facts";
import type { ScreenLink } from "./screen_link";
import { OnboardMap } from "./onboard_map";
import { currentView, drivingState } from "./screen_scene";
import { can_speak, is_speaking, speakNewest } from "./speech";
import { StopList } from "./stop_list";
import { texts } from "./texts/texts";

interface AppProps {
  readonly link: ScreenLink;
  readonly vehicle_id: string;
  readonly map_url: string;
}

export function App({ link, vehicle_id, map_url }: AppProps) {
  const t = texts.value;
  const stops = useSignal<readonly { stop_id: string; name: string; name_en: string }[]>([]);
  const view = useComputed(() => currentView(link.scene.value, link.silent_ms.value / 1000)).value;
  useSignalEffect(() => {
    document.title = texts.value.title(vehicle_id);
  });
  useSignalEffect(() => {
    speakNewest(link.scene.value?.announcements ?? [], language.value);
  });
  return (
    <div class="onboard">
      <header>
        <h1>
          <span class="vehicle">{vehicle_id}</span> {t.states[drivingState(view)]}
        </h1>
        <CloudState
          is_open={link.is_open.value}
          is_known={view !== null}
          connected={view?.connected ?? null}
        />
        {can_speak && (
          <button
            type="button"
            class="button"
            aria-pressed={is_speaking.value}
            onClick={() => (is_speaking.value = !is_speaking.value)}
          >
            {is_speaking.value ? t.sound_on : t.sound_off}
          </button>
        )}
        <LanguageSwitch />
      </header>
      <main>
        <StopList view={view} />
        <OnboardMap
          key={link.map_number.value}
          vehicle_id={vehicle_id}
          view={view}
          url={map_url}
          onStops={(found) => (stops.value = found)}
        />
        <DrivingFacts view={view} />
        <CabinButtons link={link} view={view} stops={stops.value} />
      </main>
      <AnnouncementBar link={link} view={view} />
    </div>
  );
}

function CloudState({
  is_open,
  is_known,
  connected,
}: {
  readonly is_open: boolean;
  readonly is_known: boolean;
  readonly connected: boolean | null;
}) {
  const t = texts.value;
  if (!is_open)
    return (
      <p class="cloud lost" role="alert">
        {t.no_screen_link}
      </p>
    );
  if (!is_known || connected === null) return <p class="cloud">{t.cloud_unknown}</p>;
  return (
    <p class={connected ? "cloud" : "cloud lost"} role="status">
      {connected ? t.cloud_on : t.cloud_off}
    </p>
  );
}
