"""Camera bodies with their sensors: what is stated of one, and what the model reads."""

import math
from dataclasses import field
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator
from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import (
    FROM_ZERO,
    MADE,
    NEEDED,
    OR_ZERO,
    POSITIVE,
    POSITIVE_SHARE,
    SHARE,
    SMALLEST,
    UNSEEN,
    Cell,
    Inline,
    Range,
)
from uwopt.catalog.parts.part import FORMAT, MOUNTS, Part, PartKind
from uwopt.catalog.parts.quantity import Curve, Known, Status
from uwopt.documents.key_types import refusal, to_number, to_text

MAX_GAIN_DB = 48.0  # of an inline camera that does not say
PIXELS = Range(1.0, 1e5)
BITS = Range(1.0, 32.0)
TIME_US = (1e-6, 1e10)


def _number_or_name(value: Any) -> float | str:
    if isinstance(value, str) and not value.strip()[:1].isdigit():
        return to_text(value)
    if isinstance(value, str) and value.strip().casefold().endswith(".csv"):
        return to_text(value)
    number = to_number(value)
    if not 0 < number <= 1:
        raise refusal("is not an efficiency above 0 and up to 1", "write 0.6 for 60 %")
    return number


CameraPurpose = Literal[
    "industrial camera", "board camera", "astronomy camera", "complete camera", "values of a tool"
]
NumberOrName = Annotated[float | str, BeforeValidator(_number_or_name)]


@dataclass(frozen=True, slots=True)
class Camera(Part):
    """A camera body with its sensor."""

    purpose: Annotated[
        CameraPurpose, Cell("what it is made and sold for", inline="never")
    ] = "industrial camera"
    chip: Annotated[
        str,
        Cell("maker and type of the sensor", inline=Inline(doc="type of the sensor", names=("sensor_chip",))),
    ] = ""
    colour: Annotated[Literal["mono", "colour"], Cell("sensor: mono or colour")] = "mono"
    resolution_x_px: Annotated[
        int, Cell("image width in pixels", PIXELS, needed=True, tells=True, inline=NEEDED)
    ] = 0
    resolution_y_px: Annotated[int, Cell("image height in pixels", PIXELS, needed=True, inline=NEEDED)] = 0
    pixel_pitch_um: Annotated[
        float,
        Cell(
            "pixel pitch in micrometres",
            Range(0.0, 100.0, open_low=True),
            span=(0.05, 100.0),
            needed=True,
            inline=NEEDED,
        ),
    ] = 0.0
    shutter: Annotated[Literal["global", "rolling"], Cell("shutter: global or rolling")] = "global"
    optical_format_in: ClassVar[Annotated[str, FORMAT]]
    mounts: Annotated[tuple[str, ...], MOUNTS] = ()  # () is unknown and fits nothing
    interface: Annotated[str, Cell("interface, such as USB3")] = ""
    bandwidth_mb_s: Annotated[
        Known, Cell("what the interface carries, 10^6 byte/s", POSITIVE, favours="high", unknown=math.inf)
    ] = None
    max_frame_rate_hz: Annotated[
        Known,
        Cell("highest frame rate in hertz", POSITIVE, span=(1e-6, 1e9), favours="high", unknown=math.inf),
    ] = None
    bit_depth: Annotated[int, Cell("bits of the transmitted image", BITS, status="bit_depth_status")] = 12
    bit_depth_status: Annotated[Status, UNSEEN] = "published"
    read_noise_e: Annotated[
        Known,
        Cell(
            "temporal dark noise in electrons", FROM_ZERO, span=(SMALLEST, 1e6), favours="low", inline=NEEDED
        ),
    ] = None
    saturation_e: Annotated[
        Known,
        Cell(
            "saturation capacity in electrons", POSITIVE, span=(1.0, 1e10), favours="high", unknown=math.inf
        ),
    ] = None
    dark_current_e_s: Annotated[
        Known, Cell("dark current in electrons per second", FROM_ZERO, span=(SMALLEST, 1e9), favours="low")
    ] = None
    gain_dn_per_e: Annotated[
        float | None, Cell("system gain at 0 dB in DN per electron", POSITIVE, span=(1e-9, 1e9))
    ] = None
    gain_bits: Annotated[
        int | None,
        Cell(
            "bit depth that gain_dn_per_e refers to", BITS, inline=Inline(unless="; bit_depth unless given")
        ),
    ] = None
    max_gain_db: Annotated[
        Known,
        Cell(
            "highest gain setting in decibels",
            FROM_ZERO,
            span=(SMALLEST, 120.0),
            favours="high",
            inline=Inline(default=MAX_GAIN_DB),
        ),
    ] = None
    black_level_dn: Annotated[float, Cell("offset of the image in digital numbers", FROM_ZERO)] = 0.0
    min_exposure_us: Annotated[
        Known,
        Cell(
            "shortest exposure in microseconds",
            POSITIVE,
            span=TIME_US,
            favours="low",
            at_most="max_exposure_us",
            inline=OR_ZERO,
        ),
    ] = None
    max_exposure_us: Annotated[
        Known,
        Cell("longest exposure in microseconds", POSITIVE, span=TIME_US, favours="high", unknown=math.inf),
    ] = None
    exposure_offset_us: Annotated[
        Known, Cell("time that the sensor adds to each exposure, in microseconds", FROM_ZERO, favours="high")
    ] = None
    prnu_frac: Annotated[Known, Cell("photo response non-uniformity, a share 0..1", SHARE, favours="low")] = (
        None
    )
    qe: ClassVar[
        Annotated[float, Cell("quantum efficiency at qe_nm, 0..1", POSITIVE_SHARE, span=(1e-9, 1.0))]
    ]
    qe_nm: ClassVar[Annotated[float, Cell("wavelength of qe", Range(200.0, 1200.0))]]
    qe_curve: ClassVar[
        Annotated[str, Cell("id of a curve, or a CSV with wavelength_nm, qe and channel for colour")]
    ]
    quantum_efficiency: ClassVar[
        Annotated[
            float | str,
            Cell(
                "quantum efficiency: a number 0..1, the id of a curve, or a CSV with wavelength_nm and qe",
                span=(1e-9, 1.0),
                in_files=False,
                inline=Inline(needed=True, type=NumberOrName, names=("qe", "qe_curve")),
            ),
        ]
    ]
    power_w: Annotated[
        Known, Cell("electrical power in watts", POSITIVE, span=(1e-9, 1e9), favours="low", inline=OR_ZERO)
    ] = None
    wake_up_s: Annotated[
        Known, Cell("time from switching the camera on to an image in seconds", FROM_ZERO, favours="low")
    ] = None
    standby_w: Annotated[
        Known, Cell("power of the camera while it is switched off in watts", FROM_ZERO, favours="low")
    ] = None
    body_width_mm: Annotated[Known, Cell("width of the body in millimetres", POSITIVE, favours="low")] = None
    body_height_mm: Annotated[Known, Cell("height of the body in millimetres", POSITIVE, favours="low")] = None
    body_length_mm: Annotated[
        Known, Cell("length of the body from the mount's face to its back in millimetres", POSITIVE, favours="low")
    ] = None
    plug_mm: Annotated[
        Known, Cell("room behind the body for plug and cable in millimetres", FROM_ZERO, favours="low")
    ] = None
    host_power_w: Annotated[
        Known, Cell("power of the computer that takes the images in watts", FROM_ZERO, favours="low")
    ] = None
    host_price: Annotated[
        Known, Cell("price of the computer that takes the images in USD", FROM_ZERO, favours="low")
    ] = None
    storage_gb: Annotated[float | None, Cell(in_files=False, unknown=math.inf)] = None  # of its own card
    run_time_h: Annotated[float | None, Cell(in_files=False, unknown=math.inf)] = None  # of its own battery
    min_interval_s: Annotated[Known, Cell(in_files=False, favours="low")] = None  # of its own timer
    fires_lamps: Annotated[bool, UNSEEN] = True  # with the image; a complete camera may not
    tethered: Annotated[bool, UNSEEN] = True  # needs a cable; a complete camera with battery and card does not
    perf_quality: ClassVar[Annotated[Literal["A", "B", "C", "D", "E"], Cell("grade of the sensor's figures")]]
    snr_max_db: ClassVar[
        Annotated[float, Cell("best ratio of signal to noise, as EMVA 1288 measures it", POSITIVE)]
    ]
    dynamic_range_db: ClassVar[Annotated[float, Cell("", POSITIVE)]]
    # Quantum efficiency by channel ("mono", or "red", "green", "blue"): id of a curve, scaled.
    qe_curves: Annotated[dict[str, Curve], MADE] = field(default_factory=dict)
    qe_curve_id: Annotated[str, MADE] = ""
    qe_scale: Annotated[Known, Cell(in_files=False, favours="high", unknown=1.0)] = None

    @property
    def takes_a_host(self) -> bool:
        """Whether a computer takes its images; none does where it keeps them on a card of its own."""
        return self.storage_gb is None


def _summary(camera: Camera) -> tuple[str, ...]:
    size = f"{camera.resolution_x_px} x {camera.resolution_y_px} px, {camera.pixel_pitch_um:g} µm"
    return (camera.chip, camera.colour, size, camera.shutter, "/".join(camera.mounts), camera.interface)


KIND = PartKind(
    "camera",
    Camera,
    files={"cameras.csv": "published"},
    example={
        "id": "acme-cam-5m",
        "manufacturer": "Acme",
        "model": "Cam 5M",
        "availability": "current",
        "chip": "IMX250",
        "colour": "mono",
        "resolution_x_px": "2448",
        "resolution_y_px": "2048",
        "pixel_pitch_um": "3.45",
        "shutter": "global",
        "mounts": "C",
        "interface": "USB3",
        "max_frame_rate_hz": "75",
        "bit_depth": "12",
        "read_noise_e": "2.4",
        "saturation_e": "10500",
        "power_w": "3",
        "mass_g": "60",
        "price": "1200",
        "currency": "USD",
        "price_date": "2026-11-01",
    },
    summary=_summary,
    inline_doc="A camera in a system file.",
)
