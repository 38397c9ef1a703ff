import type { Signal } from "@preact/signals";
import type { Point } from "../../shared/scene/scene";
import { texts } from "../texts/texts";
import type { EditorState } from "./editor_state";
import type { Tool } from "./tools";
import { DRAWS_LINE, TOOLS, finishLine } from "./tools";

interface ToolBarProps {
  readonly state: EditorState;
  readonly tool: Signal<Tool>;
  readonly clicked: Signal<readonly Point[]>;
}

export function ToolBar({ state, tool, clicked }: ToolBarProps) {
  const t = texts.value;
  const is_drawing = DRAWS_LINE.includes(tool.value);
  return (
    <div class="tool-bar">
      <div class="tools" role="group" aria-label={t.tools}>
        {TOOLS.map((each) => (
          <button
            key={each}
            type="button"
            class="button small"
            aria-pressed={tool.value === each}
            onClick={() => {
              tool.value = each;
              clicked.value = [];
            }}
          >
            {t.tool_names[each]}
          </button>
        ))}
      </div>
      <div class="tools">
        {is_drawing && (
          <button
            type="button"
            class="button small main"
            disabled={clicked.value.length < 2}
            onClick={() => finishLine(state, tool.value, clicked)}
          >
            {t.finish_line}
          </button>
        )}
        {clicked.value.length > 0 && (
          <button type="button" class="button small" onClick={() => (clicked.value = [])}>
            {t.drop_line}
          </button>
        )}
        <button
          type="button"
          class="button small"
          disabled={!state.can_undo.value}
          onClick={() => state.undo()}
        >
          {t.undo}
        </button>
        <button
          type="button"
          class="button small"
          disabled={!state.can_redo.value}
          onClick={() => state.redo()}
        >
          {t.redo}
        </button>
      </div>
      <p class="hint" role="status">
        {t.tool_hints[tool.value]}
      </p>
    </div>
  );
}
