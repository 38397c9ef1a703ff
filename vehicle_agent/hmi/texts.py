"""What the vehicle says, in English and Chinese: the LED screens in front and behind, and the loudspeaker.

The front talks to whom the vehicle meets, the rear to who follows: a driver behind must know why the shuttle
stands, and that nobody is asked to do anything.
"""

Words = tuple[str, str]

NOTHING: Words = ("", "")

MANUAL: Words = ("DRIVEN BY HAND", "人工驾驶")
SAFETY_STOP: Words = ("STOPPED FOR SAFETY", "安全停车")
HELD: Words = ("ON HOLD", "暂停运行")
DOORS_OPEN: Words = ("DOORS OPEN", "车门已开")
DOORS_CLOSING: Words = ("DOORS CLOSING", "车门关闭")
AFTER_YOU: Words = ("AFTER YOU", "请您先行")
STEP_ASIDE: Words = ("PLEASE STEP ASIDE", "请让一让")
SLOWING: Words = ("SLOWING FOR YOU", "减速礼让")
PASSING: Words = ("PASSING SLOWLY", "缓慢通过")
WAITING: Words = ("WAITING FOR A CLEAR ROAD", "等待会车")
WAITING_FOR_STOP: Words = ("WAITING FOR THE STOP", "等待停靠")
RESTING: Words = ("RESTING", "待命")
REQUESTED: Words = ("STOPPING ON REQUEST", "应乘客要求停车")

REAR_DRIVING: Words = ("KEEP DISTANCE", "保持车距")
REAR_YIELDING: Words = ("PEOPLE AHEAD", "前方行人")
REAR_SLOWING: Words = ("SLOWING DOWN", "正在减速")
REAR_PASSING: Words = ("DRIVING SLOWLY", "缓慢行驶")
REAR_STOPPING: Words = ("STOPPING", "即将停车")
REAR_DOORS: Words = ("PEOPLE GET ON AND OFF", "乘客上下车")
REAR_STANDING: Words = ("STANDING, PLEASE PASS", "停车中，请绕行")

SAY_STEP_ASIDE: Words = ("Please step aside, the shuttle would like to pass.", "请让一让，班车需要通过。")
SAY_AFTER_YOU: Words = ("After you. The shuttle is waiting.", "请您先行，班车等候。")
SAY_PASSING: Words = ("Attention, the shuttle is passing.", "班车通过，请注意。")
SAY_DOORS_OPEN: Words = ("Doors are opening.", "车门正在打开。")
SAY_DOORS_CLOSING: Words = ("Doors are closing.", "车门即将关闭，请注意。")
SAY_REQUESTED: Words = (
    "A stop was requested. We stop at the next safe place.",
    "已收到停车请求，将在前方安全处停车。",
)
SAY_REFUSED: Words = (
    "We cannot stop before the next stop. Please get off there.",
    "下一站之前无法停车，请在下一站下车。",
)
SAY_SAFETY_STOP: Words = (
    "We have stopped for safety. Please stay seated; the operator has been told.",
    "车辆已安全停车，请坐好，已通知运营人员。",
)
SAY_HELD: Words = ("The operator has asked us to wait. Please stay seated.", "运营人员要求车辆等待，请坐好。")


def stopping_at(name: str, name_en: str) -> Words:
    """On the screen while coming to a stop."""
    return f"STOPPING AT {(name_en or name).upper()}", f"即将停靠 {name or name_en}"


def next_stop(name: str, name_en: str) -> Words:
    """On the screen between stops."""
    return f"NEXT STOP {(name_en or name).upper()}", f"下一站 {name or name_en}"


def say_stopping_at(name: str, name_en: str) -> Words:
    return f"We are arriving at {name_en or name}.", f"{name or name_en}，到了。"


def say_next_stop(name: str, name_en: str) -> Words:
    return f"Next stop: {name_en or name}.", f"下一站：{name or name_en}。"


def screen_texts(name: str = "", name_en: str = "") -> tuple[Words, ...]:
    """Everything that a screen may show, front or rear, with this stop's name."""
    return (
        MANUAL, SAFETY_STOP, HELD, DOORS_OPEN, DOORS_CLOSING, AFTER_YOU, STEP_ASIDE, SLOWING,
        PASSING, WAITING, WAITING_FOR_STOP, RESTING, REQUESTED, REAR_DRIVING, REAR_YIELDING, REAR_SLOWING,
        REAR_PASSING, REAR_STOPPING, REAR_DOORS, REAR_STANDING, stopping_at(name, name_en),
        next_stop(name, name_en),
    )  # fmt: skip


def sentences(name: str, name_en: str) -> tuple[Words, ...]:
    """Everything that may be spoken, with this stop's name, besides an operator's own words."""
    return (
        SAY_STEP_ASIDE, SAY_AFTER_YOU, SAY_PASSING, SAY_DOORS_OPEN, SAY_DOORS_CLOSING, SAY_REQUESTED,
        SAY_REFUSED, SAY_SAFETY_STOP, SAY_HELD, say_stopping_at(name, name_en), say_next_stop(name, name_en),
    )  # fmt: skip


def every_text(language: str) -> str:
    """All characters that the screens need besides stop names; language "en" or "zh"."""
    at = {"en": 0, "zh": 1}[language]
    return "".join(text[at] for text in screen_texts())
