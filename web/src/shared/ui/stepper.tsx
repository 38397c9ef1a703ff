import { useId } from "preact/hooks";

interface StepperProps {
  readonly label: string;
  readonly value: number;
  readonly min: number;
  readonly max: number;
  readonly fewer: string;
  readonly more: string;
  readonly onChange: (value: number) => void;
}

export function Stepper({ label, value, min, max, fewer, more, onChange }: StepperProps) {
  const label_id = useId();
  return (
    <div class="field">
      <span class="label" id={label_id}>
        {label}
      </span>
      <div class="stepper" role="group" aria-labelledby={label_id}>
        <button
          type="button"
          aria-label={fewer}
          disabled={value <= min}
          onClick={() => onChange(value - 1)}
        >
          −
        </button>
        <output aria-live="polite">{value}</output>
        <button
          type="button"
          aria-label={more}
          disabled={value >= max}
          onClick={() => onChange(value + 1)}
        >
          +
        </button>
      </div>
    </div>
  );
}
