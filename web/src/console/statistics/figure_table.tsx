import { texts } from "../texts/texts";
import { csvOf } from "./csv";

interface FigureTableProps {
  readonly title: string;
  readonly file_name: string;
  readonly header: readonly string[];
  readonly rows: readonly (readonly (string | number)[])[];
}

/** The numbers behind a chart, to be read and to be taken along as CSV. */
export function FigureTable({ title, file_name, header, rows }: FigureTableProps) {
  const t = texts.value;
  return (
    <details class="figures">
      <summary>{t.numbers_of(title)}</summary>
      <a
        class="button quiet small"
        href={`data:text/csv;charset=utf-8,${encodeURIComponent(csvOf(header, rows))}`}
        download={file_name}
      >
        {t.download_csv}
      </a>
      <div class="table-scroll" tabIndex={0} role="region" aria-label={title}>
        <table class="table">
          <thead>
            <tr>
              {header.map((name) => (
                <th key={name} scope="col">
                  {name}
                </th>
              ))}
            </tr>
          </thead>
          <tbody>
            {rows.map((row, k) => (
              <tr key={k}>
                {row.map((value, column) => (
                  <td key={column} data-label={header[column]}>
                    {value}
                  </td>
                ))}
              </tr>
            ))}
          </tbody>
        </table>
      </div>
    </details>
  );
}
