"""The shuttle that the roads are drawn for.

Lanes, sections and resting places hold for any vehicle that is not larger and turns no wider. Lengths and
width: Snow Lion, section 2; wheelbase and least radius are not published and are this project's profile.
"""

LENGTH_M = 4.35
WIDTH_M = 1.63
WHEELBASE_M = 2.6
LEAST_RADIUS_M = 5.0
CURVATURE_MAX_1PM = 1.0 / LEAST_RADIUS_M
# A polyline's three-point curvature is noisier than its curve: what `validate` forgives.
CURVATURE_TOLERANCE_1PM = 0.005

REAR_OVERHANG_M = (LENGTH_M - WHEELBASE_M) / 2.0
FRONT_REACH_M = LENGTH_M - REAR_OVERHANG_M

# A shuttle stops so that its front is this far from the end of the last section that it holds, and lets go
# of a section once its tail is this far past it. Sections exclude each other on these terms.
STANDING_MARGIN_M = 0.5
RELEASE_MARGIN_M = 0.25
CLEARANCE_M = 0.3
LATERAL_COMFORT_MPS2 = 0.5
