import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";

interface DialogProps {
  readonly title: string;
  readonly onClose: () => void;
  readonly children: ComponentChildren;
}

/** A modal dialog. The browser keeps the focus inside, returns it afterwards and closes the dialog on Escape. */
export function Dialog({ title, onClose, children }: DialogProps) {
  const dialog = useRef<HTMLDialogElement>(null);
  const title_id = useId();
  useEffect(() => {
    const element = dialog.current;
    element?.showModal();
    return () => element?.close();
  }, []);
  return (
    <dialog
      ref={dialog}
      aria-labelledby={title_id}
      onCancel={(event) => {
        event.preventDefault();
        onClose();
      }}
    >
      <div class="dialog-body">
        <h2 id={title_id}>{title}</h2>
        {children}
      </div>
    </dialog>
  );
}

interface ConfirmDialogProps {
  readonly title: string;
  readonly text: string;
  readonly yes: string;
  readonly no: string;
  readonly danger?: boolean;
  /** What one looks at before one answers. */
  readonly children?: ComponentChildren;
  readonly onYes: () => void;
  readonly onNo: () => void;
}

export function ConfirmDialog({
  title,
  text,
  yes,
  no,
  danger = false,
  children,
  onYes,
  onNo,
}: ConfirmDialogProps) {
  return (
    <Dialog title={title} onClose={onNo}>
      <p>{text}</p>
      {children}
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onNo}>
          {no}
        </button>
        <button type="button" class={`button main ${danger ? "danger" : ""}`} onClick={onYes}>
          {yes}
        </button>
      </div>
    </Dialog>
  );
}
