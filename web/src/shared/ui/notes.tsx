import type { ComponentChildren } from "preact";
import type { Problem } from "../api/problem";
import { language } from "../words/language";
import { problemWords } from "../words/problem_words";
import { CheckIcon, InfoIcon, WarningIcon } from "./icons";

type Tone = "plain" | "good" | "warning" | "danger";

interface NoteProps {
  readonly tone?: Tone;
  readonly children: ComponentChildren;
}

export function Note({ tone = "plain", children }: NoteProps) {
  const sign = tone === "good" ? <CheckIcon /> : tone === "plain" ? <InfoIcon /> : <WarningIcon />;
  return (
    <div class={`note ${tone}`} role={tone === "danger" ? "alert" : "status"}>
      {sign}
      <div>{children}</div>
    </div>
  );
}

/** Says why the server refused: in the reader's words, and where there are none in the server's own. */
export function ProblemNote({ problem }: { readonly problem: Problem }) {
  const words = problemWords(problem.code, language.value);
  return (
    <Note tone="danger">
      <p>{words ?? problem.detail}</p>
      {words === null && <p class="do">{problem.code}</p>}
    </Note>
  );
}

export function Loading({ text }: { readonly text: string }) {
  return (
    <div class="loading" role="status">
      {text}
    </div>
  );
}
