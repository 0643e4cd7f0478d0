"""What a fact of a part is called in a letter to its maker, who has never seen a file of parts."""

from __future__ import annotations

import re

from uwopt.catalog.columns import Column

UNIT_SAID = re.compile(
    r",? in (?:micro|milli)?(?:metres|seconds)\b|,? in (?:watts|degrees|decibels|hertz|grams|lumens|joules|kelvin"
    r"|minutes|electrons(?: per second)?)\b"
)
#: Facts whose meaning in the catalogue speaks of other columns, or of how the program counts.
WORDS = {
    "bandwidth_mb_s": "sustained data rate of the interface",
    "mounts": "lens mount",
    "colour": "sensor, mono or colour",
    "shutter": "shutter, global or rolling",
    "geometry": "window, flat or dome",
    "interface": "data interface, such as USB3 or GigE",
    "saturation_e": "full-well capacity",
    "read_noise_e": "read noise (temporal dark noise, EMVA 1288)",
    "qe": "quantum efficiency",
    "f_number_min": "f-number wide open (largest opening)",
    "f_number_max": "f-number closed (smallest opening)",
    "aberration_pitch_um": "smallest pixel that the lens serves: wide open on its axis it still has half of the "
    "contrast at one line pair in two such pixels",
    "min_object_distance_m": "nearest focus, in air",
    "transmission_frac": "transmission, a share from 0 to 1",
    "pupil_mm": "distance of the entrance pupil behind the front of the lens",
    "max_magnification": "largest magnification at which it is still sharp, on a spacer ring or screwed out",
    "length_mm": "length of the lens",
    "diameter_mm": "largest diameter of the lens",
    "thickness_mm": "thickness of the window",
    "clear_diameter_mm": "clear diameter of the window",
    "mount": "flange or housing that it fits",
    "ports": "ports or end caps that fit it",
    "inner_length_mm": "inner length between the end caps",
    "outer_length_mm": "overall length without the port",
    "flux_lm": "luminous flux of one lamp at full (of a pulsed one while it is on)",
    "power_w": "electrical power at full load",
    "output_factor": "share of that flux that leaves the window, from 0 to 1",
    "beam_angle_deg": "full beam angle",
    "beam_medium": "where that beam angle is measured: in air or in water",
    "beam": "shape of the beam",
    "spectrum": "spectrum, as a table or a colour temperature",
    "kind": "kind of lamp",
    "max_duty_frac": "highest share of time that it may be on, from 0 to 1",
    "flash_duration_at_frac": "level at which that duration is measured: 0.5 of the peak for t0.5, 0.1 for t0.1",
    "recycle_s": "recycling time between full flashes",
    "charging_efficiency_frac": "share of the drawn power that the flash stores, from 0 to 1",
    "supply": "supply: external (by cable) or its own battery",
    "trigger": "trigger input: electrical, optical (another flash) or none",
    "trigger_delay_us": "delay from the trigger to the light",
    "trigger_jitter_us": "jitter of that delay",
    "supply_v_min": "lowest supply voltage (V)",
    "supply_v_max": "highest supply voltage (V)",
}
NOT_THEIRS = ("host_power_w", "host_price")  # the buyer's own computer


def words_for(column: Column) -> str:
    """A fact in a maker's words, without the unit that stands beside it."""
    if column.name in WORDS:
        return WORDS[column.name]
    return UNIT_SAID.sub("", column.meaning) or column.name.replace("_", " ")
