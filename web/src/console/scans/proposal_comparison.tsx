import type { Schemas } from "../../shared/api/client";
import { texts } from "../texts/texts";

const COLUMNS = ["new", "moved", "gone", "same", "unseen"] as const;

interface ProposalComparisonProps {
  readonly proposal: Schemas["ProposalView"];
  readonly comparison: Schemas["ComparisonView"];
}

/** What a proposed map changes: figures, tiles and a picture. */
export function ProposalComparison({ proposal, comparison }: ProposalComparisonProps) {
  const t = texts.value;
  const path = `/api/v1/map-proposals/${proposal.proposal_id}`;
  const centimetres = (metres: number) => (100 * metres).toFixed(1);
  return (
    <div class="proposal">
      <p>
        <strong>
          {comparison.changed_ratio === null
            ? t.proposal_nothing_in_force
            : t.proposal_changed(
                (100 * comparison.changed_ratio).toFixed(1),
                comparison.tiles_changed,
                comparison.tiles_compared,
              )}
        </strong>
      </p>
      <ul>
        {comparison.residual_median_m !== null && comparison.residual_p95_m !== null && (
          <>
            <li>
              {t.proposal_residual(
                centimetres(comparison.residual_median_m),
                centimetres(comparison.residual_p95_m),
              )}
            </li>
            <li>{t.proposal_shift(Math.hypot(...comparison.shift_m).toFixed(2))}</li>
          </>
        )}
        <li>
          {t.proposal_made_of(comparison.drives, comparison.scans, comparison.way_m.toFixed(0))}
        </li>
        <li>{t.proposal_moving(comparison.moving_removed)}</li>
        {comparison.notes.map((note) => (
          <li key={note}>{note}</li>
        ))}
      </ul>
      <img
        src={`${path}/picture`}
        alt={t.proposal_picture(proposal.request_name)}
        loading="lazy"
        width="640"
      />
      {comparison.tiles.length > 0 && (
        <table>
          <thead>
            <tr>
              <th>{t.proposal_tile}</th>
              <th>{t.proposal_columns.changed}</th>
              {COLUMNS.map((column) => (
                <th key={column}>{t.proposal_columns[column]}</th>
              ))}
            </tr>
          </thead>
          <tbody>
            {comparison.tiles.map((tile) => (
              <tr key={`${tile.ix}_${tile.iy}`}>
                <th scope="row">
                  {tile.ix}, {tile.iy}
                </th>
                <td>
                  {tile.is_added
                    ? t.proposal_tile_added
                    : `${(100 * tile.changed_ratio).toFixed(0)} %`}
                </td>
                {COLUMNS.map((column) => (
                  <td key={column}>{tile[column]}</td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      )}
      <a href={`${path}/map`} download>
        {t.proposal_file}
      </a>
    </div>
  );
}
