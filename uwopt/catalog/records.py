"""The parts that can be bought, as typed records: camera, lens, port, light, housing, complete camera.

Files use the field's units (mm, um, us, deg, g); the unit is in the name. A number that may be a
class estimate is a `Quantity`: central, low and high value, how it is known, and from where.
`None` means unknown and not estimated. Records know no mission.
"""

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.complete import Complete
from uwopt.catalog.parts.housing import Housing
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.light import Light
from uwopt.catalog.parts.part import KINDS, OF_A_DESIGN, Availability, Kind, Part
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Curve, Quantity, Status, exact

__all__ = [
    "KINDS",
    "OF_A_DESIGN",
    "Availability",
    "Camera",
    "Complete",
    "Curve",
    "Housing",
    "Kind",
    "Lens",
    "Light",
    "Part",
    "Port",
    "Quantity",
    "Status",
    "exact",
]
