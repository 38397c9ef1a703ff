"""Topic patterns: levels divided by `/`, `*` for one level, `>` for all that follow."""


def matches(pattern: str, topic: str) -> bool:
    wanted, levels = pattern.split("/"), topic.split("/")
    for i, part in enumerate(wanted):
        if part == ">":
            return len(levels) > i
        if i >= len(levels) or part not in ("*", levels[i]):
            return False
    return len(wanted) == len(levels)
