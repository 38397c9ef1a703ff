import type { Problem } from "../shared/api/problem";
import { ProblemAlert } from "../shared/ui/alerts";
import { texts } from "./texts/texts";

interface FailedLoadProps {
  readonly problem: Problem;
  readonly onRetry: () => void;
}

/** Why something could not be loaded, and a button that asks for it again. */
export function FailedLoad({ problem, onRetry }: FailedLoadProps) {
  return (
    <>
      <ProblemAlert problem={problem} />
      <button type="button" class="button main" onClick={onRetry}>
        {texts.value.try_again}
      </button>
    </>
  );
}
