import { campus } from "../shared/campus/campus";
import { second } from "../shared/live/clock";
import { LoopMark } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { place } from "./navigation";
import type { Page } from "./place";
import { fragmentOf } from "./place";
import { link, session, signOut } from "./session";
import { now_ms, seconds } from "./texts/clocks";
import { words } from "./texts/words";

const PAGES: readonly Page[] = ["live", "rides", "service", "incidents", "runs", "access"];

export function TopBar() {
  const say = words.value;
  return (
    <header class="bar">
      <LoopMark />
      <strong class="campus-name">{campus.value?.view.name ?? say.title}</strong>
      <nav aria-label={say.nav}>
        {PAGES.map((page) => (
          <a
            key={page}
            href={fragmentOf(page)}
            aria-current={place.value.page === page ? "page" : undefined}
          >
            {say[page]}
            {page === "incidents" && <OpenCount />}
          </a>
        ))}
      </nav>
      <div class="bar-end">
        <LinkSign />
        <CampusClock />
        <LanguageSwitch />
        <button type="button" class="button small" onClick={() => void signOut()}>
          {say.sign_out}
          <span class="who"> {session.value?.name}</span>
        </button>
      </div>
    </header>
  );
}

function OpenCount() {
  const waiting = link.value?.scene.value?.incidents;
  if (waiting === undefined || waiting.open === 0) return null;
  return <span class={`count ${waiting.unacknowledged > 0 ? "new" : ""}`}>{waiting.open}</span>;
}

function CampusClock() {
  return (
    <time class="campus-clock" title={words.value.campus_time}>
      {second.value > 0 && seconds(now_ms())}
    </time>
  );
}

function LinkSign() {
  const say = words.value;
  const state = link.value?.state.value ?? "connecting";
  const heard_ms = link.value?.heard_ms.value ?? null;
  const ago_s = heard_ms === null ? 0 : Math.max(0, Math.round((second.value - heard_ms) / 1000));
  const text = {
    open: say.link_open,
    connecting: say.link_connecting,
    lost: say.link_lost(ago_s),
    refused: say.link_refused,
  }[state];
  return (
    <span class={`link-sign ${state}`} role="status">
      {text}
    </span>
  );
}
