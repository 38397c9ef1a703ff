import { texts } from "../texts/texts";

/** What the shuttle shows on its LED screen and speaks. */
export function HmiOutput({
  screen,
  spoken,
}: {
  readonly screen: string;
  readonly spoken: string;
}) {
  const t = texts.value;
  return (
    <div class="hmi-output">
      <p class="led">
        <span class="visually-hidden">{t.screen}: </span>
        {screen || " "}
      </p>
      <p class="spoken">
        <span>{t.spoken}</span>
        {spoken === "" ? t.nothing_shown : `“${spoken}”`}
      </p>
    </div>
  );
}
