"""Settings rows made by hand: one design in one scene, with what a test changes."""

from __future__ import annotations

from typing import Any

import numpy as np

from uwopt.forward.part_columns import CONTINUOUS, FLASH
from uwopt.forward.scene_rows import SceneRows


def scene(**changed: Any) -> SceneRows:
    """A 12-bit camera under 20 klm of lamps that burn and dim, with what a test changes."""
    values: dict[str, Any] = dict(
        signal_e=[100.0], worst_e=None, nominal=0, read_noise_e=2.3, gain_dn_per_e=0.37, full_scale_dn=4095.0,
        black_level_dn=0.0, max_gain=16.0, well_e=10500.0, prnu_frac=0.0, dark_current_e_s=0.0, dark_time_s=5e-3,
        min_exposure_s=2e-5, exposure_offset_s=0.0, readout_s=0.0, flash_duration_s=1e-3, time_min_s=2e-5,
        time_max_s=5e-3, rate_hz=5.0, kind=CONTINUOUS, light_lm=20000.0, full_power_w=200.0, pulse_energy_j=0.0,
        charging_power_w=0.0, levels=[np.nan], dims_freely=True, min_level=0.0, max_level=1.0, working_factor=1.02,
        n_low=1.4, n_high=16.0, min_snr=10.0, mean_level=None, highlight_ratio=1.5,
    )  # fmt: skip
    values.update(changed)
    plain = ("nominal", "min_snr", "mean_level", "highlight_ratio")
    tables = ("signal_e", "worst_e", "levels")
    return SceneRows(
        **{
            name: value
            if name in plain or value is None
            else np.array([value], float)
            if name in tables
            else np.array([value])
            for name, value in values.items()
        }
    )


#: A flash that fades to 1/e in 1 ms, cut short anywhere: at its peak for 20 us up to all of it, 99 % of 1 ms.
FADING: dict[str, Any] = dict(
    kind=FLASH, light_lm=3.5e6, pulse_energy_j=120.0, full_power_w=0.0, flash_decay_s=1e-3,
    flash_duration_s=1e-3 * np.log(100.0), time_min_s=2e-5, time_max_s=0.99e-3, min_exposure_s=2e-5,
)  # fmt: skip
STEPS: dict[str, Any] = dict(dims_freely=False, levels=[0.25, 0.5, 1.0])
FLASHES: dict[str, Any] = dict(
    kind=FLASH,
    light_lm=3.5e6,
    pulse_energy_j=120.0,
    full_power_w=0.0,
    time_min_s=1e-3,
    time_max_s=1e-3,
    **STEPS,
)
