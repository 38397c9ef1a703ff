import { signal } from "@preact/signals";

/** The question that is open: answered with true once a code was accepted, with false if given up. */
export const secondFactorQuestion = signal<((answered: boolean) => void) | null>(null);

/** Asks the operator for a code; one question at a time. */
export function askSecondFactor(): Promise<boolean> {
  secondFactorQuestion.peek()?.(false);
  return new Promise((resolve) => {
    secondFactorQuestion.value = (answered) => {
      secondFactorQuestion.value = null;
      resolve(answered);
    };
  });
}
