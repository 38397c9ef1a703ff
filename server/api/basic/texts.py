"""What the pages without JavaScript say, in English and Chinese."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Language = Literal["en", "zh"]


@dataclass(frozen=True, slots=True)
class Texts:
    """states, reasons: by the codes of a ride."""

    title: str
    from_stop: str
    to_stop: str
    choose: str
    people: str
    wheelchairs: str
    when: str
    now: str
    in_minutes: str
    book: str
    refused_form: str
    no_such_ride: str
    ride_code: str
    boarding_code: str
    boarding_hint: str
    vehicle: str
    pickup: str
    arrival: str
    expected: str
    cancel: str
    book_another: str
    renewed: str
    other_language: str
    states: Mapping[str, str]
    reasons: Mapping[str, str]


EN = Texts(
    title="Campus shuttle",
    from_stop="From",
    to_stop="To",
    choose="Choose a stop",
    people="People",
    wheelchairs="Wheelchairs among them",
    when="When",
    now="Now",
    in_minutes="In {minutes} minutes",
    book="Book the ride",
    refused_form="The ride could not be booked: {detail}.",
    no_such_ride="There is no ride with this link. Check the link, or book a new ride.",
    ride_code="Ride code",
    boarding_code="Boarding code",
    boarding_hint="Enter it on the screen in the shuttle.",
    vehicle="Shuttle",
    pickup="Pickup between {begins} and {ends}",
    arrival="Arrival by {time} at the latest",
    expected="Expected at your stop at {time}",
    cancel="Cancel the ride",
    book_another="Book another ride",
    renewed="This page is renewed every 20 seconds. It shows the ride at {time}.",
    other_language="中文",
    states={
        "requested": "We are looking for a shuttle",
        "assigned": "Your ride is booked",
        "boarding": "The shuttle is at your stop",
        "aboard": "You are on your way",
        "completed": "Ride completed",
        "refused": "No shuttle can take this ride",
        "cancelled": "Ride cancelled",
        "no_show": "The shuttle left without you",
        "failed": "This ride could not be finished",
    },
    reasons={
        "no_vehicle_free": "All shuttles are busy or out of service. Try again in a few minutes.",
        "seats": "No shuttle has enough free seats. Book for fewer people, or for a later time.",
        "wheelchair": "No shuttle has so many free wheelchair places.",
        "pickup_window": "No shuttle can reach your stop in time. Choose a later time.",
        "ride_time": "The ride would take too long. Choose a later time or a nearer stop.",
        "arrival": "No shuttle can take you there in time. Choose another time.",
        "timetable": "All shuttles near you must keep the timetable. Choose another time.",
        "battery": "No shuttle has enough charge left for this ride. Try later.",
        "closed_road": "A closed road lies between these stops. Choose other stops.",
        "no_service": "The service closes before you would arrive. Choose an earlier time.",
    },
)

ZH = Texts(
    title="校园班车",
    from_stop="上车站",
    to_stop="下车站",
    choose="选择站点",
    people="人数",
    wheelchairs="其中轮椅",
    when="时间",
    now="现在",
    in_minutes="{minutes} 分钟后",
    book="预约行程",
    refused_form="无法预约：{detail}。",
    no_such_ride="没有找到该行程。请检查链接，或重新预约。",
    ride_code="行程码",
    boarding_code="上车码",
    boarding_hint="上车后在车内屏幕输入。",
    vehicle="车辆",
    pickup="{begins}–{ends} 之间上车",
    arrival="最迟 {time} 到达",
    expected="预计 {time} 到达您的站点",
    cancel="取消行程",
    book_another="再约一次",
    renewed="此页每 20 秒更新一次，显示 {time} 的情况。",
    other_language="English",
    states={
        "requested": "正在为您派车",
        "assigned": "您的行程已预约",
        "boarding": "车辆已到站",
        "aboard": "正在前往目的地",
        "completed": "行程已完成",
        "refused": "没有车辆可以完成此行程",
        "cancelled": "行程已取消",
        "no_show": "车辆已离站",
        "failed": "行程未能完成",
    },
    reasons={
        "no_vehicle_free": "所有车辆都在忙或暂停服务，请几分钟后再试。",
        "seats": "没有车辆有足够的空座。请减少人数或换个时间。",
        "wheelchair": "没有车辆有足够的轮椅位。",
        "pickup_window": "没有车辆能及时到达您的站点，请选择更晚的时间。",
        "ride_time": "乘车时间会过长，请选择更晚的时间或更近的站点。",
        "arrival": "没有车辆能及时送您到达，请换个时间。",
        "timetable": "附近的车辆都有班次要准点，请换个时间。",
        "battery": "没有车辆有足够的电量完成此行程，请稍后再试。",
        "closed_road": "道路封闭使这两个站点无法互通，请选择其他站点。",
        "no_service": "运营将在您到达之前结束，请选择更早的时间。",
    },
)


def texts_of(language: Language) -> Texts:
    return ZH if language == "zh" else EN


def language_of(asked: str, accepted: str) -> Language:
    """The language that a link asks for, or else the first one of the browser that we have."""
    if asked in ("en", "zh"):
        return "zh" if asked == "zh" else "en"
    for part in accepted.lower().split(","):
        if part.strip().startswith("zh"):
            return "zh"
        if part.strip().startswith("en"):
            return "en"
    return "en"
