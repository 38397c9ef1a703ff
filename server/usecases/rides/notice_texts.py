"""What notices say, in English and Chinese: a title and a sentence or two."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from server.domain.rides.notices import Language, NoticeKind


@dataclass(frozen=True, slots=True)
class NoticeFacts:
    """vehicle  name of the shuttle, "" for none
    stop     name of the pickup stop
    between  when the pickup is expected, as clock times; None while no time can be told
    minutes  until the expected pickup
    """

    vehicle: str
    stop: str
    between: tuple[str, str] | None
    minutes: int
    by_operator: bool


def _english(kind: NoticeKind, facts: NoticeFacts) -> tuple[str, str]:
    shuttle, stop = facts.vehicle or "Your shuttle", facts.stop
    window = "" if facts.between is None else f"between {facts.between[0]} and {facts.between[1]}"
    match kind:
        case "near":
            minutes = "1 minute" if facts.minutes == 1 else f"{facts.minutes} minutes"
            return f"{shuttle} arrives in about {minutes}", f"It is expected at {stop} {window}."
        case "here":
            return f"{shuttle} is here", f"It stands at {stop}. Get in and enter the boarding code."
        case "changed":
            if not window:
                return "Your ride has changed", f"Another shuttle picks you up at {stop}."
            return "Your ride has changed", f"The pickup is at {stop} {window}."
        case "cancelled":
            who = "The operators cancelled it." if facts.by_operator else "It was cancelled."
            return "Your ride was cancelled", f"{who} Book another one if you still need it."
        case "no_show":
            return "The shuttle left without you", "It waited as long as it could. Please book another ride."
        case "failed":
            return "Your ride could not be finished", "Book another one if you still need it."


def _chinese(kind: NoticeKind, facts: NoticeFacts) -> tuple[str, str]:
    shuttle, stop = facts.vehicle or "车辆", facts.stop
    window = "" if facts.between is None else f"{facts.between[0]} 至 {facts.between[1]} 之间"
    match kind:
        case "near":
            return f"{shuttle} 约 {facts.minutes} 分钟后到达", f"预计 {window}到达{stop}。"
        case "here":
            return f"{shuttle} 已到站", f"车辆停在{stop}。请上车并输入上车码。"
        case "changed":
            if not window:
                return "您的行程有变", f"将由另一辆车在{stop}接您。"
            return "您的行程有变", f"上车：{stop}，{window}。"
        case "cancelled":
            who = "调度员取消了此行程。" if facts.by_operator else "此行程已取消。"
            return "行程已取消", f"{who}如仍需乘车，请重新预约。"
        case "no_show":
            return "车辆已离站", "车辆已停满规定时间。请重新预约。"
        case "failed":
            return "行程未能完成", "如仍需乘车，请重新预约。"


TEXTS: Mapping[Language, Callable[[NoticeKind, NoticeFacts], tuple[str, str]]] = {
    "en": _english,
    "zh": _chinese,
}
