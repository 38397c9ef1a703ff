import { words } from "../texts/words";

/** What people in and around the shuttle read and hear. */
export function Signboard({
  screen,
  spoken,
}: {
  readonly screen: string;
  readonly spoken: string;
}) {
  const say = words.value;
  return (
    <div class="signboard">
      <p class="led">
        <span class="unseen">{say.screen}: </span>
        {screen || " "}
      </p>
      <p class="spoken">
        <span>{say.spoken}</span>
        {spoken === "" ? say.nothing_shown : `“${spoken}”`}
      </p>
    </div>
  );
}
