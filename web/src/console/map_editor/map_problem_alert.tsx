import type { Problem } from "../../shared/api/problem";
import { ProblemAlert } from "../../shared/ui/alerts";

/** The server names the shuttles and places concerned: its own words are shown too. */
export function MapProblemAlert({ problem }: { readonly problem: Problem }) {
  return (
    <>
      <ProblemAlert problem={problem} />
      {problem.detail !== "" && <p class="hint map-problem-detail">{problem.detail}</p>}
    </>
  );
}
