import { campus } from "../shared/campus/campus";
import { second } from "../shared/live/clock";
import { LoopMark } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import type { Page } from "./address";
import { fragmentOf } from "./address";
import { place } from "./navigation";
import { link, session, signOut } from "./session";
import { texts } from "./texts/texts";
import { now_ms, seconds } from "./texts/times";

const PAGES: readonly Page[] = ["live", "rides", "service", "incidents", "runs", "access"];

export function TopBar() {
  const t = texts.value;
  return (
    <header class="bar">
      <LoopMark />
      <strong class="campus-name">{campus.value?.view.name ?? t.title}</strong>
      <nav aria-label={t.nav}>
        {PAGES.map((page) => (
          <a
            key={page}
            href={fragmentOf(page)}
            aria-current={place.value.page === page ? "page" : undefined}
          >
            {t[page]}
            {page === "incidents" && <OpenCount />}
          </a>
        ))}
      </nav>
      <div class="bar-end">
        <LinkSign />
        <CampusClock />
        <LanguageSwitch />
        <button type="button" class="button small" onClick={() => void signOut()}>
          {t.sign_out}
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
    <time class="campus-clock" title={texts.value.campus_time}>
      {second.value > 0 && seconds(now_ms())}
    </time>
  );
}

function LinkSign() {
  const t = texts.value;
  const state = link.value?.state.value ?? "connecting";
  const heard_ms = link.value?.heard_ms.value ?? null;
  const ago_s = heard_ms === null ? 0 : Math.max(0, Math.round((second.value - heard_ms) / 1000));
  const text = {
    open: t.link_open,
    connecting: t.link_connecting,
    lost: t.link_lost(ago_s),
    refused: t.link_refused,
  }[state];
  return (
    <span class={`link-sign ${state}`} role="status">
      {text}
    </span>
  );
}
