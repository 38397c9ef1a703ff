"""The vehicle's texts, in English and Chinese: front and rear LED screens, and the loudspeaker.

The front screen is for people ahead. The rear screen is for traffic behind: it says why the shuttle stands,
and asks for nothing.
"""

BilingualText = tuple[str, str]

NO_TEXT: BilingualText = ("", "")

MANUAL: BilingualText = ("DRIVEN BY HAND", "人工驾驶")
SAFETY_STOP: BilingualText = ("STOPPED FOR SAFETY", "安全停车")
HELD: BilingualText = ("ON HOLD", "暂停运行")
DOORS_OPEN: BilingualText = ("DOORS OPEN", "车门已开")
DOORS_CLOSING: BilingualText = ("DOORS CLOSING", "车门关闭")
AFTER_YOU: BilingualText = ("AFTER YOU", "请您先行")
STEP_ASIDE: BilingualText = ("PLEASE STEP ASIDE", "请让一让")
SLOWING: BilingualText = ("SLOWING FOR YOU", "减速礼让")
PASSING: BilingualText = ("PASSING SLOWLY", "缓慢通过")
WAITING: BilingualText = ("WAITING FOR A CLEAR ROAD", "等待会车")
WAITING_FOR_STOP: BilingualText = ("WAITING FOR THE STOP", "等待停靠")
RESTING: BilingualText = ("RESTING", "待命")
REQUESTED: BilingualText = ("STOPPING ON REQUEST", "应乘客要求停车")

REAR_DRIVING: BilingualText = ("KEEP DISTANCE", "保持车距")
REAR_YIELDING: BilingualText = ("PEOPLE AHEAD", "前方行人")
REAR_SLOWING: BilingualText = ("SLOWING DOWN", "正在减速")
REAR_PASSING: BilingualText = ("DRIVING SLOWLY", "缓慢行驶")
REAR_STOPPING: BilingualText = ("STOPPING", "即将停车")
REAR_DOORS: BilingualText = ("PEOPLE GET ON AND OFF", "乘客上下车")
REAR_STANDING: BilingualText = ("STANDING, PLEASE PASS", "停车中，请绕行")

SAY_STEP_ASIDE: BilingualText = (
    "Please step aside, the shuttle would like to pass.",
    "请让一让，班车需要通过。",
)
SAY_AFTER_YOU: BilingualText = ("After you. The shuttle is waiting.", "请您先行，班车等候。")
SAY_PASSING: BilingualText = ("Attention, the shuttle is passing.", "班车通过，请注意。")
SAY_DOORS_OPEN: BilingualText = ("Doors are opening.", "车门正在打开。")
SAY_DOORS_CLOSING: BilingualText = ("Doors are closing.", "车门即将关闭，请注意。")
SAY_REQUESTED: BilingualText = (
    "A stop was requested. We stop at the next safe place.",
    "已收到停车请求，将在前方安全处停车。",
)
SAY_REFUSED: BilingualText = (
    "We cannot stop before the next stop. Please get off there.",
    "下一站之前无法停车，请在下一站下车。",
)
SAY_SAFETY_STOP: BilingualText = (
    "We have stopped for safety. Please stay seated; the operator has been told.",
    "车辆已安全停车，请坐好，已通知运营人员。",
)
SAY_HELD: BilingualText = (
    "The operator has asked us to wait. Please stay seated.",
    "运营人员要求车辆等待，请坐好。",
)


def stopping_at(name: str, name_en: str) -> BilingualText:
    """The screen's text near a stop."""
    return f"STOPPING AT {(name_en or name).upper()}", f"即将停靠 {name or name_en}"


def next_stop(name: str, name_en: str) -> BilingualText:
    """The screen's text between stops."""
    return f"NEXT STOP {(name_en or name).upper()}", f"下一站 {name or name_en}"


def say_stopping_at(name: str, name_en: str) -> BilingualText:
    return f"We are arriving at {name_en or name}.", f"{name or name_en}，到了。"


def say_next_stop(name: str, name_en: str) -> BilingualText:
    return f"Next stop: {name_en or name}.", f"下一站：{name or name_en}。"


def screen_texts(name: str = "", name_en: str = "") -> tuple[BilingualText, ...]:
    """All texts of the screens, front and rear, with this stop's name."""
    return (
        MANUAL, SAFETY_STOP, HELD, DOORS_OPEN, DOORS_CLOSING, AFTER_YOU, STEP_ASIDE, SLOWING,
        PASSING, WAITING, WAITING_FOR_STOP, RESTING, REQUESTED, REAR_DRIVING, REAR_YIELDING, REAR_SLOWING,
        REAR_PASSING, REAR_STOPPING, REAR_DOORS, REAR_STANDING, stopping_at(name, name_en),
        next_stop(name, name_en),
    )  # fmt: skip


def sentences(name: str, name_en: str) -> tuple[BilingualText, ...]:
    """All sentences of the loudspeaker, with this stop's name; an operator's announcements excepted."""
    return (
        SAY_STEP_ASIDE, SAY_AFTER_YOU, SAY_PASSING, SAY_DOORS_OPEN, SAY_DOORS_CLOSING, SAY_REQUESTED,
        SAY_REFUSED, SAY_SAFETY_STOP, SAY_HELD, say_stopping_at(name, name_en), say_next_stop(name, name_en),
    )  # fmt: skip


def every_text(language: str) -> str:
    """All characters that the screens need, stop names excepted; language "en" or "zh"."""
    at = {"en": 0, "zh": 1}[language]
    return "".join(text[at] for text in screen_texts())
