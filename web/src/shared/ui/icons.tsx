import type { ComponentChildren } from "preact";

function icon(children: ComponentChildren) {
  return (
    <svg
      width="20"
      height="20"
      viewBox="0 0 20 20"
      fill="none"
      stroke="currentColor"
      stroke-width="1.8"
      stroke-linecap="round"
      stroke-linejoin="round"
      aria-hidden="true"
    >
      {children}
    </svg>
  );
}

export const PlusIcon = () => icon(<path d="M10 4v12M4 10h12" />);
export const MinusIcon = () => icon(<path d="M4 10h12" />);
export const FitIcon = () => icon(<path d="M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4" />);
export const FollowIcon = () =>
  icon(
    <>
      <circle cx="10" cy="10" r="5" />
      <path d="M10 2v4M10 14v4M2 10h4M14 10h4" />
    </>,
  );
export const BackIcon = () => icon(<path d="M12 4l-6 6 6 6" />);
export const SwapIcon = () => icon(<path d="M6 3v13M3 13l3 3 3-3M14 17V4M11 7l3-3 3 3" />);
export const WarningIcon = () =>
  icon(
    <>
      <path d="M10 3l8 14H2z" />
      <path d="M10 8v4M10 14.4v.1" />
    </>,
  );
export const CheckIcon = () => icon(<path d="M4 10.5l4 4 8-9" />);
export const InfoIcon = () =>
  icon(
    <>
      <circle cx="10" cy="10" r="8" />
      <path d="M10 9v5M10 6.2v.1" />
    </>,
  );
export const HelpIcon = () =>
  icon(
    <>
      <circle cx="10" cy="10" r="8" />
      <path d="M7.8 7.8a2.2 2.2 0 1 1 3.2 2c-.7.4-1 .8-1 1.7M10 14.3v.1" />
    </>,
  );
export const SearchIcon = () =>
  icon(
    <>
      <circle cx="9" cy="9" r="5.5" />
      <path d="M13.2 13.2L17 17" />
    </>,
  );
export const PlayIcon = () => icon(<path d="M6 4l10 6-10 6z" fill="currentColor" />);
export const PreviousIcon = () => icon(<path d="M15 4l-8 6 8 6zM5 4v12" fill="currentColor" />);
export const NextIcon = () => icon(<path d="M5 4l8 6-8 6zM15 4v12" fill="currentColor" />);
export const PauseIcon = () => icon(<path d="M7 4v12M13 4v12" stroke-width="3" />);

/** The markers of pickup and destination, as on the map. */
export const PickupIcon = () => (
  <svg width="20" height="20" viewBox="0 0 20 20" aria-hidden="true">
    <circle cx="10" cy="10" r="8" fill="var(--accent)" />
    <circle cx="10" cy="10" r="3.2" fill="var(--surface)" />
  </svg>
);
export const DestinationIcon = () => (
  <svg width="20" height="20" viewBox="0 0 20 20" aria-hidden="true">
    <rect x="3" y="3" width="14" height="14" rx="3" fill="var(--ink)" />
  </svg>
);

/** Campusloop's logo: a loop from stop to stop. */
export const Logo = () => (
  <svg width="28" height="28" viewBox="0 0 64 64" aria-hidden="true">
    <rect width="64" height="64" rx="14" fill="#0b6b4f" />
    <path
      d="M20 44a14 14 0 1 1 24 0"
      fill="none"
      stroke="#fff"
      stroke-width="6"
      stroke-linecap="round"
    />
    <circle cx="20" cy="46" r="6" fill="#f2c230" />
    <rect x="38" y="40" width="12" height="12" rx="2" fill="#fff" />
  </svg>
);
