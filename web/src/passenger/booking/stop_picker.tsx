import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Stop } from "../../shared/campus/campus_geometry";
import { searchStops, stopName } from "../../shared/campus/campus_geometry";
import { language } from "../../shared/texts/language";
import { BackIcon, DestinationIcon, PickupIcon, SearchIcon } from "../../shared/ui/icons";
import { texts } from "../texts/texts";

const query = signal("");

interface StopPickerProps {
  readonly title: string;
  readonly stops: readonly Stop[];
  /** The stops that are marked as pickup and destination; "" for none. */
  readonly pickup: string;
  readonly destination: string;
  readonly onChoose: (stop_id: string) => void;
  readonly onBack: () => void;
}

export function StopPicker(props: StopPickerProps) {
  const { title, stops, onChoose, onBack } = props;
  const search = useRef<HTMLInputElement>(null);
  useEffect(() => {
    query.value = "";
    search.current?.focus();
  }, []);
  const found = searchStops(stops, query.value);
  const t = texts.value;
  return (
    <section class="picker" onKeyDown={(event) => event.key === "Escape" && onBack()}>
      <header class="picker-head">
        <button type="button" class="button quiet small" onClick={onBack}>
          <BackIcon />
          {t.back}
        </button>
        <h1>{title}</h1>
      </header>
      <form
        role="search"
        class="search"
        onSubmit={(event) => {
          event.preventDefault();
          const first = found[0];
          if (first !== undefined && query.value !== "") onChoose(first.stop_id);
        }}
      >
        <SearchIcon />
        <input
          ref={search}
          class="input"
          type="search"
          enterKeyHint="search"
          autocomplete="off"
          aria-label={t.search_stop}
          placeholder={t.search_stop}
          value={query.value}
          onInput={(event) => {
            query.value = event.currentTarget.value;
          }}
        />
      </form>
      {found.length === 0 && (
        <p class="empty" role="status">
          {t.no_stop_found}
        </p>
      )}
      <ul class="stops">
        {found.map((stop) => (
          <li key={stop.stop_id}>
            <StopChoice stop={stop} {...props} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function StopChoice({
  stop,
  pickup,
  destination,
  onChoose,
}: StopPickerProps & { readonly stop: Stop }) {
  const name = stopName(stop, language.value);
  const second_name = [stop.name, stop.name_en].find((text) => text !== "" && text !== name);
  return (
    <button type="button" class="stop-choice" onClick={() => onChoose(stop.stop_id)}>
      <span>
        {name}
        {second_name !== undefined && <small>{second_name}</small>}
      </span>
      {stop.stop_id === pickup && <PickupIcon />}
      {stop.stop_id === destination && <DestinationIcon />}
    </button>
  );
}
