import { useSignal } from "@preact/signals";
import { useEffect, useId } from "preact/hooks";
import { api, resultOf } from "../../shared/api/client";
import { chooseLanguage, language } from "../../shared/texts/language";
import { Dialog } from "../../shared/ui/dialog";
import { PAGES } from "../address";
import { is_sound_on } from "../incidents/incident_sound";
import { goTo } from "../navigation";
import { link, may } from "../session";
import { texts } from "../texts/texts";
import type { PaletteEntry } from "./palette_entries";
import { matchingEntries, rideCodeIn } from "./palette_entries";

const SHOWN_MAX = 8;

/**
 * Ctrl+K (Cmd+K) opens a list of everything that the console can show; Alt+Shift and a digit open its pages. Every
 * shortcut has a modifier key: a letter alone would act while somebody dictates (WCAG 2.1.4).
 */
export function CommandPalette() {
  const is_open = useSignal(false);
  const pages = PAGES.filter((page) => page !== "audit" || may("admin"));
  useEffect(() => {
    const pressed = (event: KeyboardEvent) => {
      if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "k") {
        event.preventDefault();
        is_open.value = document.querySelector("dialog[open]") === null;
      }
      const digit = /^Digit([1-9])$/.exec(event.code)?.[1];
      const page = digit === undefined ? undefined : pages[Number(digit) - 1];
      if (event.altKey && event.shiftKey && page !== undefined) {
        event.preventDefault();
        goTo(page);
      }
    };
    document.addEventListener("keydown", pressed);
    return () => document.removeEventListener("keydown", pressed);
  }, [pages.length]);
  return is_open.value ? <Palette onClose={() => (is_open.value = false)} /> : null;
}

function Palette({ onClose }: { readonly onClose: () => void }) {
  const t = texts.value;
  const query = useSignal("");
  const chosen = useSignal(0);
  const not_found = useSignal("");
  const id = useId();
  const found = matchingEntries(entriesOf(), query.value).slice(0, SHOWN_MAX);
  const code = found.length === 0 ? rideCodeIn(query.value) : null;
  const run = async (entry: PaletteEntry | undefined) => {
    if (entry !== undefined) {
      onClose();
      entry.run();
    } else if (code !== null) {
      const result = await resultOf(api.GET("/api/v1/rides", { params: { query: { code } } }));
      const ride = result.ok ? result.value[0] : undefined;
      if (ride === undefined) not_found.value = code;
      else {
        onClose();
        goTo("rides", ride.ride_id);
      }
    }
  };
  const keyPressed = (event: KeyboardEvent) => {
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (step === 0 || found.length === 0) return;
    event.preventDefault();
    chosen.value = (chosen.value + step + found.length) % found.length;
  };
  return (
    <Dialog title={t.palette} onClose={onClose}>
      <form
        class="palette"
        onSubmit={(event) => {
          event.preventDefault();
          void run(found[chosen.value]);
        }}
      >
        <input
          class="input"
          role="combobox"
          aria-label={t.palette_hint}
          aria-expanded={found.length > 0}
          aria-controls={`${id}-list`}
          aria-activedescendant={found.length > 0 ? `${id}-${chosen.value}` : undefined}
          placeholder={t.palette_hint}
          autocomplete="off"
          value={query.value}
          onKeyDown={keyPressed}
          onInput={(event) => {
            query.value = event.currentTarget.value;
            chosen.value = 0;
            not_found.value = "";
          }}
        />
        <ul id={`${id}-list`} role="listbox" aria-label={t.palette}>
          {found.map((entry, number) => (
            <li
              key={entry.name}
              id={`${id}-${number}`}
              role="option"
              aria-selected={number === chosen.value}
              onClick={() => void run(entry)}
            >
              {entry.name}
            </li>
          ))}
        </ul>
        <p role="status" class="hint">
          {not_found.value !== ""
            ? t.no_such_ride(not_found.value)
            : code !== null
              ? t.enter_opens_ride(code)
              : found.length === 0
                ? t.nothing_found
                : t.palette_keys}
        </p>
      </form>
    </Dialog>
  );
}

function entriesOf(): readonly PaletteEntry[] {
  const t = texts.value;
  const pages = PAGES.filter((page) => page !== "audit" || may("admin"));
  const vehicles = link.value?.scene.value?.vehicles ?? [];
  return [
    ...pages.map((page, index) => ({
      name: t.go_to_page(t[page], index + 1),
      run: () => goTo(page),
    })),
    ...vehicles.map((each) => ({
      name: each.facts.name || each.vehicle_id,
      run: () => goTo("live", each.vehicle_id),
    })),
    {
      name: is_sound_on.value ? t.turn_sound_off : t.turn_sound_on,
      run: () => (is_sound_on.value = !is_sound_on.peek()),
    },
    {
      name: language.value === "en" ? "中文" : "English",
      run: () => chooseLanguage(language.peek() === "en" ? "zh-CN" : "en"),
    },
  ];
}
