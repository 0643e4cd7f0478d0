"""Tables of water's loss are worked out once a process, and anew for whatever else is asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from uwopt.forward.spectra import loss_table
from uwopt.model.path_table import build_path_table

ASKED: dict[str, Any] = {
    "weight": np.array([[1.0, 2.0, 3.0]]), "k_lamp_per_m": np.array([0.1, 0.2, 0.4]),
    "c_camera_per_m": np.array([0.3, 0.4, 0.5]), "k_camera_per_m": None, "lamp_range_m": (1.0, 3.0),
    "camera_range_m": (1.0, 2.0), "max_order": 16, "tolerance_log": 1e-6,
}  # fmt: skip
OTHERS: dict[str, Any] = {
    "weight": np.array([1.0, 2.0, 3.0]), "k_lamp_per_m": np.array([0.1, 0.2, 0.41]),
    "c_camera_per_m": np.array([0.3, 0.45, 0.5]), "k_camera_per_m": np.array([0.2, 0.3, 0.4]),
    "lamp_range_m": (1.0, 4.0), "camera_range_m": (1.0, 4.0), "max_order": 2, "tolerance_log": 1e-2,
}  # fmt: skip


def test_the_same_table_is_made_once() -> None:
    copied = {key: value.copy() if isinstance(value, np.ndarray) else value for key, value in ASKED.items()}
    assert loss_table(**ASKED) is loss_table(**copied)


@pytest.mark.parametrize("key", OTHERS)
def test_another_table_is_that_of_what_is_asked(key: str) -> None:
    """To the last bit what the model makes of it, though another was made before."""
    loss_table(**ASKED)
    asked = ASKED | {key: OTHERS[key]}
    made, plain = loss_table(**asked), build_path_table(**asked, wavelength_nm=None)
    assert made.coefficients.tolist() == plain.coefficients.tolist()
    assert made.weight_integral.tolist() == plain.weight_integral.tolist()
    assert (made.lamp_range_m, made.camera_range_m) == (plain.lamp_range_m, plain.camera_range_m)
    assert (made.order, made.max_error_log) == (plain.order, plain.max_error_log)
