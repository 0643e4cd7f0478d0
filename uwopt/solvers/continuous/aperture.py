"""The best aperture for information, confirmed by CasADi: between defocus and diffraction, where light allows.

With time, gain and hardware as the search chose them, ln N and ln X are free: light may not exceed what
the lamps give through the aperture, nor what the pixels hold. Information is summed on fixed nodes, so that
CasADi differentiates the very formulas of the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.scene_rows import SceneRows
from uwopt.model import sensor
from uwopt.model.aberration import lens_pitch
from uwopt.model.information import TEXTURE_CONTRAST
from uwopt.model.lateral import spread_mtf
from uwopt.model.sharpness import Sharpness, round_mtf, sinc_mtf
from uwopt.solvers.continuous.pieces import Symbolic
from uwopt.solvers.continuous.program import Rules
from uwopt.solvers.settings.cell_information import square_nodes
from uwopt.solvers.settings.closed_form import Chosen, with_exposure
from uwopt.solvers.settings.windows import dark_e, window

ORDERS, ORDERS_IN_COLOUR = (16, 8), (24, 16)  # of the nodes; wide lateral colour needs more


@dataclass(frozen=True)
class ApertureProgram:
    """max ln information over (ln N, ln X) of one design in one scene, time and gain fixed; as `program.Smooth`."""

    rows: SceneRows
    chosen: Chosen
    names: tuple[str, ...] = ("f_number", "light_x")

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest of both unknowns; X as the requirements on SNR, level and saturation allow."""
        low, high = window(with_exposure(self.rows, self.chosen))
        n_low, n_high = float(self.rows.n_low[0]), float(self.rows.n_high[0])
        most = min(float(high[0]), float(np.exp(self.log_light_at(np.log(n_low)))))
        return np.log([n_low, max(float(low[0]), 1e-12 * most)]), np.log([max(n_high, n_low), most])

    def rules(self, x: Sequence[Symbolic]) -> Rules:
        """What is minimised, and the light that does not pass."""
        log_n, log_x = x
        return Rules(-self.log_information(log_n, log_x), {"light": log_x - self.log_light_at(log_n)}, {})

    def log_light_at(self, log_n: Any) -> Any:
        """ln of the most light that passes an aperture in the chosen time; the chosen level where power binds."""
        rows, chosen = self.rows, self.chosen
        level = max(float(rows.max_level[0]), float(chosen.level[0]))
        most = (
            float(rows.light_lm[0])
            * min(level, 1.0)
            * float(chosen.time_s[0])
            / float(rows.working_factor[0]) ** 2
        )
        return float(np.log(most)) - 2.0 * log_n

    def log_information(self, log_n: Any, log_x: Any) -> Any:
        """ln of the information [bit/m^2]; floats or symbols."""
        rows, sharp = self.rows, self.rows.sharp
        assert sharp is not None
        f_number, light_x = np.exp(log_n), np.exp(log_x)
        at = with_exposure(rows, self.chosen)
        signal = float(rows.signal_e[0, rows.nominal]) * light_x
        veil = float(rows.total_e[0, rows.nominal] - rows.signal_e[0, rows.nominal]) * light_x
        snr = float(sharp.texture_gain[0]) * sensor.snr(
            signal, veil_e=veil, read_noise_e=float(rows.read_noise_e[0]), dark_e=float(dark_e(at)[0]),
            gain_dn_per_e=float(rows.gain_dn_per_e[0] * self.chosen.gain[0]), prnu_frac=float(rows.prnu_frac[0]),
        )  # fmt: skip
        here = Sharpness(
            working_f_number=f_number * float(rows.working_factor[0]), wavelength_nm=float(sharp.wavelength_nm[0]),
            pixel_pitch_m=float(sharp.pixel_pitch_m[0]), defocus_px=float(sharp.rms_disc_px[0, 1]) / f_number,
            lens_pitch_px=lens_pitch(
                float(sharp.rated_pitch_px[0]), aberration_f1_px=float(sharp.aberration_px[0]), f_number=f_number,
                exponent=float(sharp.aberration_exponent[0]), field_blur=sharp.lens_blur("rms"),
            ),
        )  # fmt: skip
        blur = float(sharp.blur_px_per_s[0, 1] * rows.blur_s(self.chosen.time_s)[0])
        (_, spread), *_ = sharp.groups("rms")
        nodes = square_nodes(ORDERS if spread is None else ORDERS_IN_COLOUR, both_signs=spread is not None)
        fixed = sinc_mtf(nodes.along) * sinc_mtf(nodes.across) * sinc_mtf(nodes.along, width_px=blur)
        if spread is not None:
            k = float(sharp.rms_k_along[0]) * nodes.along + float(sharp.rms_k_across[0]) * nodes.across
            fixed = fixed * spread_mtf(k, table=spread)
        radius = np.hypot(nodes.along, nodes.across)[0]
        total = 0.0
        for nu, share, factor in zip(radius, nodes.weight[0], fixed[0], strict=True):
            total = total + float(share) * np.log(
                1.0 + (TEXTURE_CONTRAST * snr * float(factor) * round_mtf(float(nu), sharpness=here)) ** 2
            )
        return np.log(total / float(sharp.pixel_area_m2[0]))


def confirmed(rows: SceneRows, chosen: Chosen) -> dict[str, Any] | None:
    """CasADi's best aperture beside the search's; None where sun or a missing record leaves nothing to confirm."""
    if rows.sharp is None or rows.sunlit:
        return None
    from uwopt.solvers.continuous import casadi_ipopt

    program = ApertureProgram(rows, chosen)
    start = np.log([chosen.f_number[0], chosen.light_x[0]])
    found = casadi_ipopt.solve_by_ipopt(program, np.clip(start, *program.bounds))
    gain = program.log_information(*found.x) - program.log_information(*start)
    return {
        "f_number": float(np.exp(found.x[0])), "searched_f_number": float(chosen.f_number[0]),
        "gain_rel": float(np.expm1(gain)), "kkt_residual": found.kkt_residual,
    }  # fmt: skip
