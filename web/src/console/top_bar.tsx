import { campus } from "../shared/campus/campus";
import { monotonic_ms } from "../shared/live/clock";
import { Logo } from "../shared/ui/icons";
import { LanguageSwitch } from "../shared/ui/language_switch";
import { PAGES, fragmentOf } from "./address";
import { address } from "./navigation";
import { age_s, is_stale, link, may, session, signOut } from "./session";
import { texts } from "./texts/texts";
import { formatTimeWithSeconds, now_ms } from "./texts/times";

export function TopBar() {
  const t = texts.value;
  return (
    <header class="bar">
      <Logo />
      <strong class="campus-name">{campus.value?.view.name ?? t.title}</strong>
      <nav aria-label={t.nav}>
        {PAGES.filter((page) => page !== "audit" || may("admin")).map((page) => (
          <a
            key={page}
            href={fragmentOf(page)}
            aria-current={address.value.page === page ? "page" : undefined}
          >
            {t[page]}
            {page === "incidents" && <OpenIncidentCount />}
          </a>
        ))}
      </nav>
      <div class="bar-end">
        <ConnectionStatus />
        <CampusClock />
        <LanguageSwitch />
        <button
          type="button"
          class="button small"
          title={session.value?.name}
          onClick={() => void signOut()}
        >
          {t.sign_out}
          <span class="operator-name"> {session.value?.name}</span>
        </button>
      </div>
    </header>
  );
}

function OpenIncidentCount() {
  const count = link.value?.scene.value?.incidents;
  if (count === undefined || count.open === 0) return null;
  return <span class={`count ${count.unacknowledged > 0 ? "new" : ""}`}>{count.open}</span>;
}

function CampusClock() {
  return (
    <time class="campus-clock" title={texts.value.campus_time}>
      {monotonic_ms.value > 0 && formatTimeWithSeconds(now_ms())}
    </time>
  );
}

function ConnectionStatus() {
  const t = texts.value;
  const state = link.value?.state.value ?? "connecting";
  const shown = is_stale.value && state === "open" ? "lost" : state;
  const text = {
    open: t.link_open,
    connecting: t.link_connecting,
    lost: t.link_lost(age_s.value),
    refused: t.link_refused,
  }[shown];
  return (
    <span class={`connection ${shown}`} role="status">
      {text}
    </span>
  );
}
