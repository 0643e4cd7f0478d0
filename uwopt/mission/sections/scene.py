"""Water, floor and light of one place: a scene of a mission."""

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import BeforeValidator, Field

from uwopt.documents.key_types import (
    CHOICE,
    NUMBER,
    Section,
    Share,
    Text,
    all_optional,
)
from uwopt.mission import keys as words
from uwopt.mission.sections.requirements import Requirements
from uwopt.mission.sections.vehicle import Vehicle

if TYPE_CHECKING:
    VehicleOverride = Vehicle
    RequirementsOverride = Requirements
else:
    VehicleOverride = all_optional(Vehicle, "VehicleOverride")
    RequirementsOverride = all_optional(Requirements, "RequirementsOverride")


class Scene(Section):
    """Water, floor and light of one place; keys of `vehicle` and `requirements` may be overridden here."""

    name: Text = Field(default="scene 1", description="name of the scene, each its own")
    water: Annotated[str, BeforeValidator(words.to_water)] | None = Field(
        default=None,
        description=f"Jerlov type ({', '.join(words.JERLOV_TYPES)}) or the name of a CSV profile; beside one of "
        f"{', '.join(words.CLARITY_KEYS)} the type whose colour that water has",
    )
    c_per_m: Annotated[float, Field(ge=0.055, le=20), NUMBER] | None = Field(
        default=None,
        description="beam attenuation at 530 nm in 1/m, the water's own included, instead of water; of all "
        "readings the one to have",
    )
    visibility_m: Annotated[float, Field(ge=0.3, le=80), NUMBER] | None = Field(
        default=None,
        description="farthest distance in metres at which a black disc is seen horizontally in daylight, instead of "
        "water",
    )
    secchi_m: Annotated[float, Field(ge=0.4, le=80), NUMBER] | None = Field(
        default=None, description="Secchi depth in metres, instead of water"
    )
    turbidity_ntu: Annotated[float, Field(ge=0.02, le=15), NUMBER] | None = Field(
        default=None, description="turbidity in NTU or FNU, instead of water; leaves most open of all readings"
    )
    water_table: Annotated[Literal["measured", "solonenko-mobley"], CHOICE] | None = Field(
        default=None,
        description="table of the Jerlov types: measured or solonenko-mobley; measured where it has the type",
    )
    seafloor: Annotated[float | str, BeforeValidator(words.to_seafloor)] = Field(
        description=f"seafloor: {', '.join(words.SEAFLOORS)}, a reflectance 0..1, or the name of a "
        "CSV spectrum; of a wall, a ceiling or a target in mid-water, its reflectance"
    )
    target: Annotated[words.Target, BeforeValidator(words.to_target), CHOICE] = Field(
        default="floor",
        description="thing that is looked at: floor (the camera looks straight down), wall (it looks level and faces "
        "it), ceiling (it looks straight up at it: ice, a hull, a roof; not at the water's surface, which mirrors), or "
        "mid_water (things that stand or swim at the distance, looked at level with open water behind them)",
    )
    depth_m: Annotated[float, Field(ge=0, le=11_000), NUMBER] = Field(
        description="depth of the scene in metres: of the floor; of the camera where it looks level or up"
    )
    temperature_c: Annotated[float, Field(ge=-3, le=45), NUMBER] = Field(
        default=10.0, description="temperature of the water in degrees Celsius"
    )
    salinity_psu: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        default=35.0, description="salinity of the water in practical salinity units, 0 for fresh water"
    )
    backscatter_ratio: Annotated[float, Field(gt=0, le=0.5), NUMBER] = Field(
        default=0.0183, description="backscattered share of all scattering, b_b / b"
    )
    phase_function: Text = Field(
        default="fournier-forand",
        description="how particles scatter: fournier-forand or henyey-greenstein for the backscatter_ratio, "
        "petzold-<station> as measured, or the name of a CSV file (angle_deg, phase_per_sr)",
    )
    multiple_scattering: bool = Field(
        default=True,
        description="whether light that is scattered more than once counts; false: single scattering, as the equations "
        "of Jaffe and McGlamery have it",
    )
    sun_lux: Annotated[float, Field(ge=0, le=200_000), NUMBER] = Field(
        default=0.0, description="sunlight at the surface in lux, 0 for night"
    )
    sun_elevation_deg: Annotated[float, Field(ge=0, le=90), NUMBER] = Field(
        default=60.0, description="elevation of the sun in degrees above the horizon"
    )
    subject_speed_m_s: Annotated[float, Field(ge=0, le=50), NUMBER] = Field(
        default=0.0,
        description="largest speed of a subject over the floor in any direction in metres per second, such as of a "
        "fish; adds to blur and skew, not to overlap and frame rate",
    )
    time_share: Share | None = Field(
        default=None,
        description="share 0..1 of the mission's time spent here, for energy and storage; equal unless given",
    )
    vehicle: VehicleOverride | None = Field(
        default=None, description="keys of vehicle that differ in this scene"
    )
    requirements: RequirementsOverride | None = Field(
        default=None, description="keys of requirements that differ in this scene"
    )

    @property
    def clarity(self) -> tuple[str, float] | None:
        """The key and value of how far one sees in this water; None where a type or a file says all."""
        found = ((key, getattr(self, key)) for key in words.CLARITY_KEYS)
        return next(((key, value) for key, value in found if value is not None), None)
