import type { OnboardScene } from "../../shared/scene/onboard_scene";
import { texts } from "../texts/texts";
import {
  BANDS_M,
  kindOf,
  scanPoints,
  type ShownSign,
  signOutline,
  speedOf,
  TRACK_KINDS,
  type TrackKind,
} from "./seen_things";

/** More are counted only. */
const ROWS_MAX = 8;

/** Road users, signs and points of one moment in words, with the symbols that the map has for them. */
export function SeenList({ scene }: { readonly scene: OnboardScene }) {
  const t = texts.value;
  const { tracks = [], signs = [], tracks_by = "", scan = null } = scene;
  const age_s = (scene.tracks_age_s ?? 0).toFixed(1);
  return (
    <section class="seen" aria-label={t.seen}>
      <h3>{t.seen}</h3>
      <p class="hint">{t.tracks_by[tracks_by]}</p>
      {tracks_by !== "" && (
        <>
          <ul class="plain seen-kinds">
            {TRACK_KINDS.map((kind) => (
              <li key={kind}>
                <TrackSymbol kind={kind} is_own={tracks_by === "own"} />
                {t.of_kind(
                  t.track_kinds[kind],
                  tracks.filter((one) => kindOf(one) === kind).length,
                )}
              </li>
            ))}
          </ul>
          {tracks.length > 0 && (
            <details>
              <summary>{t.track_rows(tracks.length, age_s)}</summary>
              <table class="seen-tracks">
                <thead>
                  <tr>
                    <th scope="col">{t.track_number}</th>
                    <th scope="col">{t.track_kind}</th>
                    <th scope="col">{t.track_speed}</th>
                    <th scope="col">{t.track_size}</th>
                  </tr>
                </thead>
                <tbody>
                  {tracks.slice(0, ROWS_MAX).map((track) => (
                    <tr key={track[0]} class={track[9] ? "yielded" : undefined}>
                      <th scope="row">{track[0]}</th>
                      <td>
                        {t.track_kinds[kindOf(track)]}
                        {track[9] && ` · ${t.st_yielded}`}
                      </td>
                      <td>{t.kmh((3.6 * speedOf(track)).toFixed(1))}</td>
                      <td>{t.metres_by(track[5].toFixed(1), track[6].toFixed(1))}</td>
                    </tr>
                  ))}
                </tbody>
              </table>
              {tracks.length > ROWS_MAX && (
                <p class="hint">{t.more_tracks(tracks.length - ROWS_MAX)}</p>
              )}
            </details>
          )}
        </>
      )}
      {signs.length > 0 && (
        <ul class="plain seen-signs">
          {signs.map(([sign_id, kind, , , , distance_m]) => (
            <li key={sign_id}>
              <SignSymbol kind={kind} />
              {t.sign_at(t.sign_kinds[kind], distance_m.toFixed(0))}
            </li>
          ))}
        </ul>
      )}
      <p class="hint seen-points">
        {scan === null
          ? t.no_scan
          : t.points_of_scan(scanPoints(scan).length / 3, scan.age_s.toFixed(1))}
        {scan !== null && <br />}
        {scan !== null &&
          t.points_by_height(...BANDS_M).map((text, band) => (
            <span key={text} data-band={band}>
              <i aria-hidden="true" />
              {text}
            </span>
          ))}
      </p>
    </section>
  );
}

function TrackSymbol({ kind, is_own }: { readonly kind: TrackKind; readonly is_own: boolean }) {
  const shape = { class: `seen-${kind}`, "stroke-dasharray": is_own ? undefined : "4 3" };
  return (
    <svg class="seen-symbol" viewBox="-12 -12 24 24" aria-hidden="true">
      {kind === "pedestrian" && <circle r="7" {...shape} />}
      {kind === "cyclist" && <rect x="-10" y="-4" width="20" height="8" {...shape} />}
      {kind === "vehicle" && <rect x="-10" y="-7" width="20" height="14" {...shape} />}
      {kind === "other" && <rect x="-6" y="-6" width="12" height="12" {...shape} />}
    </svg>
  );
}

function SignSymbol({ kind }: { readonly kind: ShownSign[1] }) {
  const outline = signOutline(kind, 9).map((corner) => corner.join(" "));
  return (
    <svg class="seen-symbol" viewBox="-12 -12 24 24" aria-hidden="true">
      <path class={`seen-sign-${kind}`} d={`M${outline.join("L")}Z`} />
      {kind === "stop" && <path class="seen-sign-bar" d="M-5 0H5" />}
      {kind === "board" && (
        <text y="4" text-anchor="middle">
          ?
        </text>
      )}
    </svg>
  );
}
