"""Designs whose sharpness several tests look at."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from uwopt.model import lateral
from uwopt.model.sharpness import Sharpness

GOOD = Sharpness(working_f_number=2.8, wavelength_nm=540.0, pixel_pitch_m=3.45e-6)
PLAIN = replace(GOOD, motion_blur_px=0.5, defocus_px=1.5, lens_pitch_px=0.8)
NOTHING = replace(GOOD, working_f_number=0.0)  # a pixel and no lens at all

def led_table() -> lateral.SpreadTable:
    """A white lamp's two humps over an index that falls with wavelength, as sea water's does."""
    wavelength = np.linspace(400.0, 700.0, 61)
    lamp = 2.1 * np.exp(-0.5 * ((wavelength - 450.7) / 11.67) ** 2)
    lamp += 1.85 * np.exp(-0.5 * ((wavelength - 565.4) / 64.6) ** 2)
    index = 1.3247 + 3.3e3 / wavelength**2 + 3.2e7 / wavelength**4
    return lateral.spread_table(wavelength, electrons_per_nm=lamp * wavelength, n_water=index)


LED = led_table()


def with_colour(base: Sharpness, spread_px: float, direction_rad: float) -> Sharpness:
    k = 2.0 * math.pi * spread_px / LED.index_rms
    return replace(
        base,
        lateral_k_along=k * math.cos(direction_rad),
        lateral_k_across=k * math.sin(direction_rad),
        spread=LED,
    )
