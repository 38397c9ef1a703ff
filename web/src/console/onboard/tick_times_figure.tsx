import type { TickTimes } from "../../shared/scene/onboard_scene";
import { texts } from "../texts/texts";

/** A tick has so long. */
const TICK_US = 20_000;

/** How long each part of the slowest tick took. */
export function TickTimesFigure({ times }: { readonly times: TickTimes }) {
  const t = texts.value;
  const around_us = Math.max(times.whole_us - times.rooms.reduce((sum, [, us]) => sum + us, 0), 0);
  const parts: readonly (readonly [string, number])[] = [
    ...times.rooms.map(([room, us]) => [t.rooms_onboard[room] ?? room, us] as const),
    [t.tick_around, around_us],
  ];
  const longest_us = Math.max(...parts.map(([, us]) => us), 1);
  return (
    <figure class="chart tick-times">
      <figcaption>
        {t.tick_times(
          (times.whole_us / 1000).toFixed(1),
          (TICK_US / 1000).toFixed(0),
          (times.late_us / 1000).toFixed(1),
        )}
      </figcaption>
      <table>
        <tbody>
          {parts.map(([name, us]) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td>
                <i style={{ width: `${(100 * us) / longest_us}%` }} aria-hidden="true" />
              </td>
              <td>{t.milliseconds((us / 1000).toFixed(2))}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </figure>
  );
}
