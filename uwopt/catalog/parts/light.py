"""Lamps: what is stated of one, and what the model reads."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from uwopt.catalog.parts.cell import (
    FROM_ZERO,
    MADE,
    OR_ZERO,
    POSITIVE,
    POSITIVE_SHARE,
    SHARE,
    UNSEEN,
    Cell,
    Inline,
    Range,
)
from uwopt.catalog.parts.part import Part, PartKind, marked_number, shown_depth
from uwopt.catalog.parts.quantity import Curve, Known, Status, exact
from uwopt.documents.key_types import NUMBER

LightKind = Literal["continuous", "pulsed_led", "flash"]
Beam = Literal["disc", "cone", "cosine-power", "tabulated"]
Medium = Literal["air", "water", "not stated"]
Supply = Literal["external", "battery", "unknown"]
Trigger = Literal["electrical", "optical", "none", "unknown"]
LampPurpose = Literal["vehicle lamp", "video light", "photo strobe", "dive torch"]
Levels = tuple[Annotated[float, Field(ge=0, le=1), NUMBER], ...]
SHARE_SPAN = (1e-9, 1.0)
TIME_US = (1e-6, 1e10)


@dataclass(frozen=True, slots=True)
class Light(Part):
    """A lamp: burning (continuous), an LED that pulses (pulsed_led), or a xenon tube (flash)."""

    purpose: Annotated[
        LampPurpose, Cell("what it is made and sold for", inline="never")
    ] = "vehicle lamp"
    kind: Annotated[
        LightKind,
        Cell(
            "kind of lamp: continuous, pulsed_led or flash",
            needed=True,
            inline=Inline(default=None, unless="; continuous unless given"),
        ),
    ] = "continuous"
    flux_lm: Annotated[
        Known,
        Cell(
            "nameplate flux of one lamp at full (pulsed: while on) in lumens",
            POSITIVE,
            span=(1e-3, 1e10),
            favours="high",
            tells=True,
            inline=Inline(doc="flux at full (pulsed: while on) in lumens", names=("luminous_flux_lm",)),
        ),
    ] = None
    power_w: Annotated[
        Known,
        Cell(
            "electrical power at full (pulsed: while on) in watts",
            POSITIVE,
            span=(1e-9, 1e9),
            favours="low",
            inline=OR_ZERO,
        ),
    ] = None
    mean_power_w: ClassVar[Annotated[float, Cell("of a pulsed lamp", POSITIVE, span=(1e-9, 1e9))]]
    output_factor: Annotated[
        Known,
        Cell(
            "share 0..1 of the flux that leaves the window",
            POSITIVE_SHARE,
            span=SHARE_SPAN,
            favours="high",
            unknown=1.0,
            inline=Inline(default=1.0),
        ),
    ] = None
    beam: Annotated[
        Beam, Cell("shape of the beam: disc, cone, cosine-power or tabulated", inline=Inline(default=None))
    ] = "cosine-power"
    # Full angle; half power for cosine-power, edge for disc and cone.
    beam_half_angle_deg: ClassVar[
        Annotated[
            float,
            Cell(
                "half-angle of the beam in water in degrees",
                Range(0.0, 90.0, True, True),
                span=(0.05, 89.95),
                in_files=False,
                inline=Inline(),
            ),
        ]
    ]
    beam_angle_deg: Annotated[
        Known,
        Cell(
            "full angle of the beam in beam_medium in degrees",
            Range(0.0, 180.0, True, True),
            span=(0.05, 179.9),
            favours="low",
        ),
    ] = None
    beam_medium: Annotated[
        Medium,
        Cell(
            "where beam_angle_deg is measured: air, water or not stated (taken as air)",
            inline=Inline(default=None),
        ),
    ] = "not stated"
    beam_profile: Annotated[
        Curve | None,
        Cell(
            "id of a beam profile, a CSV with angle_deg and intensity, or an IES file",
            form="text",
            inline=Inline(
                doc="id of a beam profile, or a CSV with angle_deg and intensity", names=("beam_profile_id",)
            ),
        ),
    ] = None
    peak_candela: ClassVar[Annotated[float, Cell("", POSITIVE, span=(1e-6, 1e12))]]
    beam_profile_is_candela: Annotated[bool, UNSEEN] = False  # else relative
    beam_profile_id: Annotated[str, MADE] = ""
    spectrum_id: Annotated[str, MADE] = "generic-led"
    spectrum: Annotated[
        Curve | None,
        Cell(
            "id of a spectrum, or a CSV with wavelength_nm and relative_power",
            form="text",
            inline=Inline(names=("spectrum_id",)),
        ),
    ] = None  # the user's own; else that of the id
    front_radius_mm: Annotated[
        float, Cell("radius of the lamp's front in millimetres", POSITIVE, span=(1e-3, 1e5))
    ] = 20.0
    dim_levels: Annotated[
        tuple[float, ...] | None,
        Cell(
            "shares of full such as 1|0.5|0.25, or continuous, or none",
            form="text",
            status="dim_status",
            inline=Inline(doc="list of the light levels as shares 0..1", type=Levels),
        ),
    ] = None  # None: continuous
    dim_step_count: ClassVar[Annotated[int, Cell("", Range(1.0))]]
    dim_min_frac: Annotated[float, Cell("least light level of a continuous dimmer, a share 0..1", SHARE)] = (
        0.0
    )
    dim_status: Annotated[Status, UNSEEN] = "published"
    switchable: Annotated[
        Literal["yes", "no"],
        Cell("whether a lamp that burns may go off between images: yes, or no as discharge lamps"),
    ] = "yes"
    warm_up_s: Annotated[
        Known, Cell("time from switching a lamp on to full light in seconds", FROM_ZERO, favours="low")
    ] = None
    standby_w: Annotated[
        Known, Cell("power of a lamp that is switched off in watts", FROM_ZERO, favours="low")
    ] = None
    min_pulse_us: Annotated[
        Known,
        Cell(
            "shortest pulse in microseconds",
            POSITIVE,
            span=TIME_US,
            favours="low",
            at_most="max_pulse_us",
            inline=OR_ZERO,
        ),
    ] = None
    max_pulse_us: Annotated[
        Known, Cell("longest pulse in microseconds", POSITIVE, span=TIME_US, favours="high", unknown=math.inf)
    ] = None
    max_duty_frac: Annotated[
        Known,
        Cell(
            "highest share 0..1 of time that it is on",
            POSITIVE_SHARE,
            span=SHARE_SPAN,
            favours="high",
            unknown=1.0,
        ),
    ] = None
    max_rate_hz: Annotated[
        Known,
        Cell("highest pulse rate in hertz", POSITIVE, span=(1e-6, 1e9), favours="high", unknown=math.inf),
    ] = None
    flash_energy_j: Annotated[
        Known, Cell("full energy of one flash in joules", POSITIVE, span=(1e-9, 1e9), favours="high")
    ] = None
    flash_efficacy_lm_s_per_j: Annotated[
        Known,
        Cell(
            "light of a flash in lumen-seconds per joule",
            POSITIVE,
            span=(1e-6, 1e4),
            favours="high",
            unknown=35.0,
            inline=Inline(unless="35 unless given"),
        ),
    ] = None
    flash_duration_us: Annotated[
        Known,
        Cell("duration of a flash in microseconds", POSITIVE, span=TIME_US, favours="low", unknown=math.inf),
    ] = None
    flash_duration_at_frac: Annotated[
        Known,
        Cell(
            "share 0..1 of its peak to which the flash has faded then: 0.5 for t0.5, 0.1 for t0.1; 1: steady light",
            POSITIVE_SHARE,
            span=SHARE_SPAN,
            favours="low",
            unknown=1.0,
            inline=Inline(unless="that of its class unless given"),
        ),
    ] = None
    recycle_s: Annotated[
        Known, Cell("time between full flashes in seconds", POSITIVE, favours="low", inline=OR_ZERO)
    ] = None
    charging_efficiency_frac: Annotated[
        Known,
        Cell(
            "share 0..1 of the power drawn that the flash stores",
            POSITIVE_SHARE,
            span=SHARE_SPAN,
            favours="high",
            unknown=1.0,
        ),
    ] = None
    guide_number_m: Annotated[
        float | None, Cell("on land, ISO 100", POSITIVE, span=(1e-3, 1e5), tells=True, inline="never")
    ] = None
    colour_temperature_k: Annotated[float | None, Cell("colour temperature in kelvin", POSITIVE)] = None
    cri: ClassVar[Annotated[float, Cell("colour rendering index", Range(0.0, 100.0, open_low=True))]]
    depth_rating_m: Annotated[float | None, Cell("depth rating in metres", POSITIVE)] = (
        None  # never estimated
    )
    supply: Annotated[
        Supply,
        Cell(
            "where its power comes from: external (a cable), battery (of its own, switched by hand) or unknown; "
            "external unless given"
        ),
    ] = "external"
    run_time_min: Annotated[float | None, Cell("how long its own battery lasts at full in minutes", POSITIVE)] = None
    trigger: Annotated[
        Trigger,
        Cell("what fires a pulse or a flash: electrical (an input), optical (another flash), none or unknown"),
    ] = "unknown"
    trigger_delay_us: ClassVar[Annotated[float, Cell("time from the trigger to the light", FROM_ZERO)]]
    trigger_jitter_us: ClassVar[Annotated[float, Cell("spread of that time", FROM_ZERO)]]
    supply_v_min: ClassVar[Annotated[float, Cell("", POSITIVE, at_most="supply_v_max")]]
    supply_v_max: ClassVar[Annotated[float, Cell("", POSITIVE)]]
    mass_water_g: ClassVar[Annotated[float, Cell("", FROM_ZERO)]]

    @property
    def wired(self) -> bool:
        """Whether a cable feeds it or fires it; a torch that burns on a battery of its own has none."""
        return not (self.supply == "battery" and self.kind == "continuous")


def _summary(light: Light) -> tuple[str, ...]:
    is_flash = light.kind == "flash"
    output = marked_number("", light.flash_energy_j, " J") if is_flash else marked_number("", light.flux_lm, " lm")
    power = "" if is_flash else marked_number("", light.power_w, " W")
    medium = "(medium not stated)" if light.beam_medium == "not stated" else f"in {light.beam_medium}"
    angle = marked_number("", light.beam_angle_deg, f" deg {medium}")
    supply = {"battery": "own battery", "unknown": "supply unknown"}.get(light.supply, "")
    return (light.kind, output, power, angle, shown_depth(light.depth_rating_m), supply)


KIND = PartKind(
    "light",
    Light,
    files={"lights.csv": "published", "generic_lights.csv": "generic"},
    example={
        "id": "acme-lamp-5000",
        "manufacturer": "Acme",
        "model": "Lamp 5000",
        "availability": "current",
        "kind": "continuous",
        "flux_lm": "5000",
        "power_w": "50",
        "beam": "cosine-power",
        "beam_angle_deg": "90",
        "beam_medium": "water",
        "dim_levels": "1|0.5|0.25",
        "depth_rating_m": "300",
        "mass_g": "500",
        "price": "700",
        "currency": "USD",
    },
    summary=_summary,
    inline_doc="A light in a system file; all numbers are of one lamp.",
)


#: Stands where a mission may do without lamps: it draws nothing, costs nothing, and gives next to no light.
NO_LAMP = Light(
    id="no-lamp", model="no lamp", price=exact(0.0), mass_g=exact(0.0), flux_lm=exact(1e-6), power_w=exact(0.0),
    output_factor=exact(1.0), beam_angle_deg=exact(120.0), beam_medium="water", depth_rating_m=11_000.0,
    dim_levels=(1.0,),
)  # fmt: skip
