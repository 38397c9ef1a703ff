import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Stop } from "../shared/map/campus_shape";
import { stopName, stopsMatching } from "../shared/map/campus_shape";
import { BackIcon, DestinationMark, PickupMark, SearchIcon } from "../shared/ui/icons";
import { language } from "../shared/words/language";
import type { End } from "./booking_form";
import { chooseStop, destination, pickup } from "./booking_form";
import { words } from "./words";

const query = signal("");

interface StopPickerProps {
  readonly end: End;
  readonly stops: readonly Stop[];
  readonly onDone: () => void;
}

export function StopPicker({ end, stops, onDone }: StopPickerProps) {
  const search = useRef<HTMLInputElement>(null);
  useEffect(() => {
    query.value = "";
    search.current?.focus();
  }, []);
  const found = stopsMatching(stops, query.value);
  const say = words.value;
  const choose = (stop_id: string) => {
    chooseStop(end, stop_id);
    onDone();
  };
  return (
    <section class="picker" onKeyDown={(event) => event.key === "Escape" && onDone()}>
      <header class="picker-head">
        <button type="button" class="button quiet small" onClick={onDone}>
          <BackIcon />
          {say.back}
        </button>
        <h2>{end === "pickup" ? say.choose_pickup : say.choose_destination}</h2>
      </header>
      <form
        role="search"
        class="search"
        onSubmit={(event) => {
          event.preventDefault();
          const first = found[0];
          if (first !== undefined && query.value !== "") choose(first.stop_id);
        }}
      >
        <SearchIcon />
        <input
          ref={search}
          class="input"
          type="search"
          enterKeyHint="search"
          autocomplete="off"
          aria-label={say.search_stop}
          placeholder={say.search_stop}
          value={query.value}
          onInput={(event) => {
            query.value = event.currentTarget.value;
          }}
        />
      </form>
      {found.length === 0 && (
        <p class="empty" role="status">
          {say.no_stop_found}
        </p>
      )}
      <ul class="stops">
        {found.map((stop) => (
          <li key={stop.stop_id}>
            <StopChoice stop={stop} onChoose={() => choose(stop.stop_id)} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function StopChoice({ stop, onChoose }: { readonly stop: Stop; readonly onChoose: () => void }) {
  const name = stopName(stop, language.value);
  const other = [stop.name, stop.name_en].find((text) => text !== "" && text !== name);
  return (
    <button type="button" class="stop-choice" onClick={onChoose}>
      <span>
        {name}
        {other !== undefined && <small>{other}</small>}
      </span>
      {stop.stop_id === pickup.value && <PickupMark />}
      {stop.stop_id === destination.value && <DestinationMark />}
    </button>
  );
}
