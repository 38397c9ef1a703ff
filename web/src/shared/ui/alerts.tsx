import type { ComponentChildren } from "preact";
import type { Problem } from "../api/problem";
import { language } from "../texts/language";
import { problemText } from "../texts/problem_texts";
import { CheckIcon, InfoIcon, WarningIcon } from "./icons";

type Tone = "plain" | "good" | "warning" | "danger";

interface AlertProps {
  readonly tone?: Tone;
  readonly children: ComponentChildren;
}

export function Alert({ tone = "plain", children }: AlertProps) {
  const icon = tone === "good" ? <CheckIcon /> : tone === "plain" ? <InfoIcon /> : <WarningIcon />;
  return (
    <div class={`alert ${tone}`} role={tone === "danger" ? "alert" : "status"}>
      {icon}
      <div>{children}</div>
    </div>
  );
}

/** Why the server refused a request: our text in the reader's language, or else the server's detail and code. */
export function ProblemAlert({ problem }: { readonly problem: Problem }) {
  const text = problemText(problem.code, language.value);
  return (
    <Alert tone="danger">
      <p>{text ?? problem.detail}</p>
      {text === null && <p class="problem-code">{problem.code}</p>}
    </Alert>
  );
}

export function Loading({ text }: { readonly text: string }) {
  return (
    <div class="loading" role="status">
      {text}
    </div>
  );
}
