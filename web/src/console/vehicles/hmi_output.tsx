import { texts } from "../texts/texts";

/** What people in and around the shuttle read and hear. */
export function Signboard({
  screen,
  spoken,
}: {
  readonly screen: string;
  readonly spoken: string;
}) {
  const t = texts.value;
  return (
    <div class="signboard">
      <p class="led">
        <span class="unseen">{t.screen}: </span>
        {screen || " "}
      </p>
      <p class="spoken">
        <span>{t.spoken}</span>
        {spoken === "" ? t.nothing_shown : `“${spoken}”`}
      </p>
    </div>
  );
}
