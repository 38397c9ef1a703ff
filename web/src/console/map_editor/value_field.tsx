import { useId } from "preact/hooks";

interface ValueFieldProps {
  readonly label: string;
  readonly value: string;
  readonly number?: { readonly min: number; readonly max: number };
  /** The field was left, or Enter pressed, with another value that is valid. */
  readonly onTake: (value: string) => void;
}

export function ValueField({ label, value, number, onTake }: ValueFieldProps) {
  const id = useId();
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <input
        id={id}
        class="input"
        value={value}
        {...(number === undefined
          ? { maxLength: 200 }
          : { type: "number", step: "any", required: true, ...number })}
        onChange={(event) => {
          const input = event.currentTarget;
          if (input.reportValidity() && input.value !== value) onTake(input.value);
        }}
      />
    </div>
  );
}
