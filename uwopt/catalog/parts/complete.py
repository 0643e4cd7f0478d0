"""Complete cameras, bought as one: camera, lens and port in one housing, with what is stated of them as a whole.

A row states the numbers of its camera, lens and port beside its own. The search knows it by these pieces: a camera,
a lens and a port that go with each other alone. Price, mass and depth rating are those of the whole.
"""

from dataclasses import replace
from typing import Annotated, ClassVar, Literal, TypeVar

from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.camera import Camera
from uwopt.catalog.parts.cell import FROM_ZERO, POSITIVE, UNSEEN, Cell, Range
from uwopt.catalog.parts.housing import SIZE_MM, Housing
from uwopt.catalog.parts.lens import Lens
from uwopt.catalog.parts.part import Part, PartKind, shown_depth
from uwopt.catalog.parts.port import Port
from uwopt.catalog.parts.quantity import Known, exact

Family = Literal["subsea camera", "action camera", "compact", "mirrorless"]
P = TypeVar("P", bound=Part)
MOUNT = "complete"  # of its camera and lens, which no other part has

#: Columns of the pieces that a complete camera has no use for: what fits, and the room that it takes.
OF_A_PART_ALONE = frozenset((
    "mounts", "optical_format_in", "mount", "purpose", "image_circle_mm", "body_width_mm", "body_height_mm",
    "body_length_mm", "plug_mm", "length_mm", "diameter_mm", "pupil_mm", "host_power_w", "host_price", "filter_thread",
    "is_zoom", "spacers_mm", "thread_travel_mm", "max_magnification",
))  # fmt: skip


@dataclass(frozen=True, slots=True)
class Complete(Part):
    """A camera with lens and port in one housing, that is bought as a whole."""

    family: Annotated[
        Family,
        Cell("subsea camera, action camera, compact, or mirrorless in its housing", needed=True, tells=True),
    ] = "subsea camera"
    projection: Annotated[
        Literal["rectilinear", "fisheye"],
        Cell("how the lens projects; a fisheye is listed and not searched"),
    ] = "rectilinear"
    view_deg: ClassVar[
        Annotated[float, Cell("full angle of view, where no focal length is stated", Range(0.0, 180.0, True, True))]
    ]
    view_side: ClassVar[
        Annotated[Literal["horizontal", "vertical", "diagonal"], Cell("what view_deg is measured across")]
    ]
    view_medium: ClassVar[Annotated[Literal["air", "water"], Cell("where view_deg is measured")]]
    depth_rating_m: Annotated[float | None, Cell("depth rating of the whole in metres", POSITIVE)] = None
    outer_diameter_mm: Annotated[
        Known, Cell("outer diameter, or the larger side of its front, in millimetres", POSITIVE, span=SIZE_MM)
    ] = None
    outer_length_mm: Annotated[Known, Cell("length over all in millimetres", POSITIVE, span=SIZE_MM)] = None
    mass_water_g: ClassVar[Annotated[float, Cell("mass in water in grams; below 0 it floats")]]
    supply: Annotated[
        Literal["external", "battery", "unknown"], Cell("what feeds it: external, its own battery, or unknown")
    ] = "unknown"
    run_time_min: Annotated[float | None, Cell("how long its battery lasts in minutes", POSITIVE)] = None
    storage_gb: Annotated[float | None, Cell("room for images that it has itself, 10^9 byte", POSITIVE)] = None
    min_interval_s: Annotated[
        Known, Cell("shortest interval between stills of its own timer in seconds", POSITIVE, favours="low")
    ] = None
    lamp_trigger: Annotated[
        Literal["yes", "no", "unknown"], Cell("whether it gives a signal that fires lamps with the image")
    ] = "unknown"
    own_light_lm: Annotated[
        float | None, Cell("lumens of the lamps that it has itself; they stay off in the search", FROM_ZERO)
    ] = None
    displaced_g: Annotated[Known, Cell(in_files=False)] = None  # of water
    own_camera: Annotated[Camera, UNSEEN] = Camera("")
    own_lens: Annotated[Lens, UNSEEN] = Lens("")
    own_port: Annotated[Port, UNSEEN] = Port("")

    @property
    def pieces(self) -> tuple[Camera, Lens, Port]:
        """Camera, lens and port, tied to each other; price and mass of the whole are the port's.

        What a battery of its own feeds draws nothing from the vehicle.
        """
        hull = Housing(
            f"{self.id} housing", outer_diameter_mm=self.outer_diameter_mm, outer_length_mm=self.outer_length_mm,
            depth_rating_m=self.depth_rating_m, displaced_g=self.displaced_g,
        )  # fmt: skip
        alone = self.supply == "battery" and self.storage_gb is not None
        camera = replace(
            self._named(self.own_camera, "camera"), mounts=(MOUNT,), price=None, mass_g=None,
            storage_gb=self.storage_gb, min_interval_s=self.min_interval_s, fires_lamps=self.lamp_trigger == "yes",
            tethered=not alone, run_time_h=None if self.run_time_min is None else self.run_time_min / 60.0,
        )  # fmt: skip
        if self.supply == "battery":
            none = exact(0.0, "derived", "fed by its own battery")
            camera = replace(camera, power_w=none, standby_w=none)
        lens = replace(self._named(self.own_lens, "lens"), mounts=(MOUNT,), price=None, mass_g=None, spacers_mm=())
        lamps_lm = self.own_light_lm
        dark = f"its own lamps of {lamps_lm:g} lm stay off: no beam is known of them" if lamps_lm else ""
        port = replace(
            self._named(self.own_port, "port"), housing=hull, depth_rating_m=self.depth_rating_m, price=self.price,
            currency=self.currency, price_date=self.price_date, mass_g=self.mass_g, generic=self.generic,
            source_url=self.source_url, availability=self.availability, note="; ".join(filter(None, (dark, self.note))),
        )  # fmt: skip
        return camera, lens, port

    def _named(self, piece: P, kind: str) -> P:
        """A piece by the name of the whole, and tied to it."""
        return replace(
            piece, id=f"{self.id} {kind}", complete=self.id, manufacturer=self.manufacturer, model=self.model
        )


def _summary(complete: Complete) -> tuple[str, ...]:
    camera, lens = complete.own_camera, complete.own_lens
    size = f"{camera.resolution_x_px} x {camera.resolution_y_px} px" if camera.resolution_x_px else ""
    pitch = f"{camera.pixel_pitch_um:.3g} µm" if camera.pixel_pitch_um else ""
    focal = f"{lens.focal_length_mm:.3g} mm" if lens.focal_length_mm else ""
    return (complete.family, size, pitch, focal, shown_depth(complete.depth_rating_m))


KIND = PartKind(
    "complete",
    Complete,
    files={"complete.csv": "published"},
    example={
        "id": "acme-subcam-5",
        "manufacturer": "Acme",
        "model": "SubCam 5",
        "availability": "current",
        "family": "subsea camera",
        "supply": "external",
        "lamp_trigger": "yes",
        "colour": "colour",
        "chip": "IMX264",
        "resolution_x_px": "2448",
        "resolution_y_px": "2048",
        "pixel_pitch_um": "3.45",
        "shutter": "global",
        "interface": "GigE",
        "focal_length_mm": "8",
        "f_number_min": "1.8",
        "geometry": "flat",
        "material": "sapphire",
        "thickness_mm": "8",
        "depth_rating_m": "1000",
        "outer_diameter_mm": "90",
        "outer_length_mm": "220",
        "mass_g": "2500",
        "price": "9000",
        "currency": "USD",
        "price_date": "2026-11-01",
    },
    summary=_summary,
    inline_doc="",
    pieces={Camera: OF_A_PART_ALONE, Lens: OF_A_PART_ALONE, Port: OF_A_PART_ALONE},
)
