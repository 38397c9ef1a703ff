import { campus } from "../../shared/campus/campus";
import { stopName } from "../texts/stop_names";
import { texts } from "../texts/texts";

/** The address of each stop's board, for the screen that hangs there. */
export function BoardLinks() {
  const t = texts.value;
  const stops = campus.value?.geometry.stops ?? [];
  return (
    <section class="block card">
      <h2>{t.stop_boards}</h2>
      <p class="hint">{t.stop_boards_hint}</p>
      <ul class="board-links">
        {stops.map(({ stop_id }) => (
          <li key={stop_id}>
            <a href={`/board/${encodeURIComponent(stop_id)}`} target="_blank" rel="noreferrer">
              {stopName(stop_id)}
            </a>
          </li>
        ))}
      </ul>
    </section>
  );
}
