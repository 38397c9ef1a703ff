"""How far an infrastructure camera's word that nobody is in its area may be believed.

A single picture misses people (5 % each, NUS), so several in a row must be free of them. A camera that sees
nobody where the vehicle itself tracks somebody is not believed for minutes: it looks elsewhere, or stands
still. Its word that somebody is there needs no trust; it only slows the vehicle. A word that has not come by
the server, which knows its cameras, is not believed either.
"""

from collections.abc import Collection

import msgspec

from vehicle_agent.signals import PedestrianPresence


class CameraTrust(msgspec.Struct, frozen=True):
    """stamp_ns       of the camera's newest picture
    clear_looks    pictures in a row without anybody
    contradicted   of these, in a row, with somebody whom the vehicle tracks in the area
    distrusted_ns  when it was last caught, 0 never
    """

    area_id: str
    stamp_ns: int
    clear_looks: int = 0
    contradicted: int = 0
    distrusted_ns: int = 0


class TrustRules(msgspec.Struct, frozen=True):
    """looks_min     pictures in a row without anybody
    gap_ns         two pictures farther apart are not in a row
    contradicted_max  a camera is caught by so many pictures in a row that lack a tracked person
    distrust_ns    it is not believed for this long then
    """

    looks_min: int = 3
    gap_ns: int = 1_300_000_000
    contradicted_max: int = 3
    distrust_ns: int = 300_000_000_000

    def update(
        self,
        before: tuple[CameraTrust, ...],
        presence: tuple[PedestrianPresence, ...],
        tracked_in: Collection[str],
    ) -> tuple[CameraTrust, ...]:
        """After the newest report of each camera. tracked_in: areas with people whom the vehicle tracks."""
        known = {trust.area_id: trust for trust in before}
        after = []
        for report in presence:
            trust = known.get(report.area_id) or CameraTrust(report.area_id, 0)
            # A forged word of people only slows the vehicle; a forged word of nobody is not heard.
            if report.stamp_ns != trust.stamp_ns and (report.by_server or report.count > 0):
                trust = self._looked(trust, report, report.area_id in tracked_in)
            after.append(trust)
        # A camera that is silent starts again, but what it was caught at is not forgotten.
        reporting = {trust.area_id for trust in after}
        silent = (t for t in before if t.area_id not in reporting and t.distrusted_ns)
        after += [CameraTrust(t.area_id, t.stamp_ns, distrusted_ns=t.distrusted_ns) for t in silent]
        return tuple(after)

    def clear_ns(self, trust: CameraTrust, now_ns: int) -> int:
        """Stamp of the picture by which the area is believed to be free, 0 if it is not."""
        caught = trust.distrusted_ns > 0 and now_ns - trust.distrusted_ns < self.distrust_ns
        is_clear = trust.clear_looks >= self.looks_min and trust.contradicted == 0 and not caught
        return trust.stamp_ns if is_clear else 0

    def _looked(self, trust: CameraTrust, report: PedestrianPresence, is_tracked: bool) -> CameraTrust:
        in_a_row = 0 < report.stamp_ns - trust.stamp_ns <= self.gap_ns
        clear = report.count == 0
        looks = (trust.clear_looks if in_a_row else 0) + 1 if clear else 0
        contradicted = (trust.contradicted if in_a_row else 0) + 1 if clear and is_tracked else 0
        distrusted_ns = report.stamp_ns if contradicted >= self.contradicted_max else trust.distrusted_ns
        return CameraTrust(report.area_id, report.stamp_ns, looks, contradicted, distrusted_ns)
