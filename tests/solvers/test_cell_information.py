"""Information of settings against the model's own rule, and its bound: the tangent of a logarithm that is concave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from settings_attack import detail, sharp
from thorough import THOROUGH

from uwopt.forward.sharpness import SharpRows
from uwopt.model import lateral
from uwopt.model.information import RULE_ERROR
from uwopt.model.sharpness import J1_ZERO
from uwopt.solvers.settings.cell_information import Information, bell_until

NM = np.linspace(400.0, 700.0, 61)
WHITE = lateral.spread_table(  # two humps, so that colour comes back after its first null
    NM, electrons_per_nm=np.exp(-(((NM - 570.0) / 45.0) ** 2)) + 0.5 * np.exp(-(((NM - 450.0) / 12.0) ** 2)),
    n_water=1.345 - 2e-5 * (NM - 400.0),
)  # fmt: skip
DRAWN = 3000 if THOROUGH else 400
MANY_ENDS = 20_000 if THOROUGH else 600
COLOUR_PX = {"none": 0.0, "a little": 0.1, "much": 1.5}  # rms


def rows(colour_px: float) -> SharpRows:
    """Many designs that differ in all that counts, behind flat ports where colour is spread."""
    rng = np.random.default_rng(7)
    one = sharp()
    many = one.take(np.zeros(DRAWN, int))
    return replace(
        coloured(many, colour_px, rng), rated_pitch_px=rng.uniform(0.0, 1.5, DRAWN),
        aberration_px=rng.uniform(0.0, 2.0, DRAWN), aberration_exponent=rng.uniform(2.0, 6.0, DRAWN),
        rms_disc_px=many.rms_disc_px * 3.0 * rng.random((DRAWN, 1)),
        pixel_pitch_m=rng.uniform(2e-6, 8e-6, DRAWN),
        detail=replace(detail(1.0).take(np.zeros(DRAWN, int)), texture_gain=rng.uniform(1.0, 1.6, DRAWN)),
    )  # fmt: skip


def coloured(some: SharpRows, colour_px: float, rng: np.random.Generator) -> SharpRows:
    """Designs whose colours are spread so far, or a little less, in any direction."""
    n = len(some.pixel_pitch_m)
    k, angle = 2.0 * np.pi * colour_px / WHITE.index_rms * rng.uniform(0.5, 1.0, n), rng.uniform(0.2, 1.3, n)
    return replace(some, rms_k_along=k * np.cos(angle), rms_k_across=k * np.sin(angle), spreads=(WHITE,))


def drawn(rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """F-numbers, times [s] and SNR."""
    f_number, time_s = (low * (high / low) ** rng.random(DRAWN) for low, high in ((1.4, 16.0), (2e-5, 2e-3)))
    return f_number, time_s, np.exp(rng.uniform(0.0, 5.0, DRAWN))


def by_model(some: SharpRows, f_number: np.ndarray, time_s: np.ndarray, snr: np.ndarray) -> np.ndarray:
    """Bit per pixel by the model."""
    bits = some.information_bit_per_m2(snr, f_number=f_number, working_f_number=1.1 * f_number, blur_s=time_s)
    return np.asarray(bits * some.pixel_area_m2)


@pytest.mark.parametrize("colour", COLOUR_PX)
def test_what_the_search_maximises_is_the_figure_of_the_model(colour: str) -> None:
    some = rows(COLOUR_PX[colour])
    f_number, time_s, snr = drawn(np.random.default_rng(1))
    found = Information(some).value(
        np.arange(DRAWN), snr, f_number=f_number, working=1.1 * f_number, blur_s=time_s
    )
    assert found == pytest.approx(by_model(some, f_number, time_s, snr), rel=1e-12)


@pytest.mark.parametrize("colour", COLOUR_PX)
@pytest.mark.parametrize("far", [0.1, 1.0], ids=["near", "far"])
def test_no_image_has_more_than_the_tangent_at_another(colour: str, far: float) -> None:
    """Any image against the bound from the tangent at another image of the same design: ln I is concave."""
    some, rng = rows(COLOUR_PX[colour]), np.random.default_rng(2)
    f_number, time_s, snr = drawn(rng)
    to_n, to_t, to_snr = (a * (b / a) ** far for a, b in zip((f_number, time_s, snr), drawn(rng), strict=True))
    column = np.arange(DRAWN), np.log(to_snr)[:, None], np.log(to_n / f_number)[:, None], np.log(to_t / time_s)[:, None]
    ends = np.minimum(f_number, to_n), f_number, np.maximum(f_number, to_n)
    least = np.minimum(time_s, to_t)
    given = dict(centre_log_snr=np.log(snr), f_number=ends, factor=np.full(DRAWN, 1.1), blur_s=(least, time_s))
    information, truth = Information(some), by_model(some, to_n, to_t, to_snr)
    for surely in (np.zeros(DRAWN, bool), np.ones(DRAWN, bool)):
        bound = information.bound(*column, **given, wanted=np.ones((DRAWN, 1), bool), surely=surely)[:, 0]
        assert (truth <= bound * (1.0 + RULE_ERROR)).all()
    if far < 1.0:
        assert np.median(bound / truth) < 1.05, "a tangent lies near what it touches"


@pytest.mark.parametrize("colour", COLOUR_PX)
@pytest.mark.parametrize("end", ["disc", "pupil", "smear", "all"])
@pytest.mark.parametrize("step", [0.03, 0.3])
def test_transfers_that_end_early_stay_under_their_bound(end: str, step: float, colour: str) -> None:
    """A disc's, a pupil's or a smear's null lies at 2 to 0.02 cycles per pixel, and settings near by are bounded.

    Sums whose nodes know nothing of the null bend there, which the integral does not.
    """
    n, rng = MANY_ENDS, np.random.default_rng(5)
    every = np.arange(n)
    f_number, snr = rng.uniform(1.4, 16.0, n), np.exp(5.6 * np.sqrt(rng.random(n)))
    period_px = np.exp(rng.uniform(np.log(0.5), np.log(50.0), n))

    def near(value: np.ndarray) -> np.ndarray:
        return np.asarray(value * np.exp(step * rng.choice([-1.0, 1.0], n) * np.square(rng.random(n))))

    some = coloured(sharp().take(np.zeros(n, int)), COLOUR_PX[colour], rng)
    some = replace(
        some, rated_pitch_px=rng.uniform(0.0, 1.5, n), aberration_px=rng.uniform(0.0, 3.0, n),
        aberration_exponent=rng.uniform(2.0, 6.0, n), rms_disc_px=0.1 * some.rms_disc_px,
        pixel_pitch_m=np.full(n, 2e-5),
    )  # fmt: skip
    still = rng.uniform(0.05, 1.5, n) / some.blur_px_per_s[:, 1]
    if end in ("disc", "all"):
        some = replace(some, rms_disc_px=np.outer(J1_ZERO / np.pi * period_px * f_number, np.ones(3)))
    if end in ("pupil", "all"):
        some = replace(some, pixel_pitch_m=1.1 * f_number * some.wavelength_nm * 1e-9 / rng.permutation(period_px))
    if end in ("smear", "all"):
        still = rng.permutation(period_px) / some.blur_px_per_s[:, 1]
    to_n, to_s, to_snr = near(f_number), near(still), near(snr)
    information = Information(some)
    shifts = (np.log(to / start)[:, None] for to, start in ((to_n, f_number), (to_s, still)))
    bound = information.bound(
        every, np.log(to_snr)[:, None], *shifts, centre_log_snr=np.log(snr),
        f_number=(np.minimum(f_number, to_n), f_number, np.maximum(f_number, to_n)), factor=np.full(n, 1.1),
        blur_s=(np.minimum(still, to_s), still), wanted=np.ones((n, 1), bool), surely=np.ones(n, bool),
    )[:, 0]  # fmt: skip
    truth = by_model(some, to_n, to_s, to_snr)
    assert (truth <= bound * (1.0 + RULE_ERROR)).all()
    if step < 0.1:
        assert np.median(bound / truth) < 1.001, "a tangent lies near what it touches"


def test_a_null_within_the_image_leaves_its_other_nodes_close() -> None:
    """What is known in the middle of a cell is close there, and enough where it is sharpest, though a disc's or a
    pupil's null moves through its image."""
    n, rng = 200, np.random.default_rng(11)
    f_number, snr, wide = rng.uniform(1.4, 4.0, n), np.full(n, 30.0), np.exp(0.3)
    some = coloured(sharp().take(np.zeros(n, int)), COLOUR_PX["much"], rng)
    period_px = rng.uniform(2.0, 4.0, n)  # nulls at 0.25 to 0.5 cycles per pixel
    discs = replace(some, rms_disc_px=np.outer(J1_ZERO / np.pi * period_px * f_number, np.ones(3)))
    pupils = replace(some, pixel_pitch_m=1.1 * f_number * some.wavelength_nm * 1e-9 / period_px)
    still = 0.1 / some.blur_px_per_s[:, 1]
    for seen, sharper in ((discs, wide), (pupils, 1.0 / wide)):
        bound = Information(seen).bound(
            np.arange(n), np.tile(np.log(snr)[:, None], 2), np.tile([0.0, np.log(sharper)], (n, 1)), np.zeros((n, 2)),
            centre_log_snr=np.log(snr), f_number=(f_number / wide, f_number, f_number * wide), factor=np.full(n, 1.1),
            blur_s=(still, still), wanted=np.ones((n, 2), bool), surely=np.ones(n, bool),
        )  # fmt: skip
        truth = np.stack([by_model(seen, to, still, snr) for to in (f_number, f_number * sharper)], axis=1)
        assert (truth <= bound * (1.0 + RULE_ERROR)).all()
        assert (bound / truth)[:, 0].max() < 1.01, "nodes far from the null are close"


def test_what_lateral_colour_joins() -> None:
    """All of the image where no colour is spread, rays where it falls along them, nodes where it comes back."""
    joined = {
        colour: {group.joined for group in Information(rows(px)).groups}
        for colour, px in COLOUR_PX.items()
    }
    assert joined == {"none": {"all"}, "a little": {"rays"}, "much": {"none"}}
    end = bell_until(WHITE)
    k = np.linspace(0.05, 1.0, 400) * end
    slope = np.diff(np.log(lateral.spread_mtf(k, table=WHITE))) / np.diff(np.log(k))
    assert (np.diff(slope) < 1e-3).all() and end * WHITE.index_rms < 4.0
