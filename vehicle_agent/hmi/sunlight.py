"""The sun's height above the horizon, from the time and the place: whether headlights are needed."""

import math

# 2000-01-01 12:00 UTC in seconds since 1970.
_J2000_S = 946_728_000.0
_DAY_S = 86_400.0


def sun_elevation_rad(utc_s: float, latitude_deg: float, longitude_deg: float) -> float:
    """The height of the sun's centre, without refraction, to 0.02 degrees from 1950 to 2050.

    The low-precision formulas of the Astronomical Almanac, section C.
    """
    days = (utc_s - _J2000_S) / _DAY_S
    mean_longitude = math.radians(280.460 + 0.9856474 * days)
    anomaly = math.radians(357.528 + 0.9856003 * days)
    ecliptic = (
        mean_longitude + math.radians(1.915) * math.sin(anomaly) + math.radians(0.020) * math.sin(2 * anomaly)
    )
    obliquity = math.radians(23.439 - 0.0000004 * days)
    right_ascension = math.atan2(math.cos(obliquity) * math.sin(ecliptic), math.cos(ecliptic))
    declination = math.asin(math.sin(obliquity) * math.sin(ecliptic))
    sidereal = math.radians(280.46062 + 360.98564737 * days + longitude_deg)
    hour_angle = sidereal - right_ascension
    latitude = math.radians(latitude_deg)
    return math.asin(
        math.sin(latitude) * math.sin(declination)
        + math.cos(latitude) * math.cos(declination) * math.cos(hour_angle)
    )
