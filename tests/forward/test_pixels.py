"""The pixels that may decide, against all of them."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from uwopt.forward import figures
from uwopt.forward.light_columns import ImageLight
from uwopt.forward.pixels import decisive_pixels, fewest_pixels
from uwopt.model.image_mean import reached_by_most

N_PIXELS = 120
MIXTURES = ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (30.0, 1.0), (1.0, 30.0), (1e-3, 1e-3))


def mixed(sources: Any) -> Any:
    """SNR at some noise, PRNU and light of each source, and contrast, (n, n_altitudes, n_pixels)."""
    for mixture in MIXTURES:
        signal, veil = (sum(x * source[k] for x, source in zip(mixture, sources, strict=False)) for k in (0, 1))
        every = signal + veil
        for noise, prnu in product((1e-6, 0.1, 10.0), (0.0, 0.01, 1.0)):
            yield signal / np.sqrt(every + np.square(prnu * every) + noise)
        yield np.divide(signal, every, where=every > 0, out=np.zeros_like(every))


def images(n_sources: int, seed: int) -> list[tuple[Any, Any]]:
    """Random ones with ties, and pixels that no light comes from."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(n_sources):
        signal = np.round(rng.uniform(0.1, 1.0, (4, 2, N_PIXELS)), 1)
        veil = np.round(rng.uniform(0.0, 1.0, signal.shape), 1)
        signal[0, 0, :3] = 0.0
        veil[0, 0, 0] = 0.0
        found.append((signal, veil))
    return found


@pytest.mark.parametrize("n_sources", [1, 2])
def test_the_fewest_pixels_decide_in_any_mixture(n_sources: int) -> None:
    for seed, may_miss in product(range(4), (0, 1, 7)):
        sources = images(n_sources, seed)
        kept = fewest_pixels(sources, may_miss)
        for every, few in zip(mixed(sources), mixed(kept), strict=True):
            assert reached_by_most(few, may_miss) == pytest.approx(reached_by_most(every, may_miss), rel=1e-12)


def test_fewer_pixels_are_left_than_signal_and_veil_alone_tell_apart() -> None:
    sources = images(1, 5)
    for may_miss in (0, 7):
        assert fewest_pixels(sources, may_miss)[0][0].shape[2] < decisive_pixels(*sources[0], may_miss)[0].shape[2]


def test_scale_of_a_source_leaves_its_pixels() -> None:
    lamps, sun = images(2, 6)
    scales = ((1.0, 1.0), (1e-200, 1.0), (1.0, 1e200))
    sizes = {fewest_pixels([tuple(a * c for c in lamps), tuple(b * c for c in sun)], 3)[0][0].shape for a, b in scales}
    assert len(sizes) == 1


def test_pixels_of_many_designs_are_those_of_each(monkeypatch: pytest.MonkeyPatch) -> None:
    signal, veil = images(1, 7)[0]
    light_x = np.array([1.0, 10.0, 100.0, 1000.0])
    rows: Any = SimpleNamespace(
        light=ImageLight(signal[:, :, 0], worst_e=signal, worst_veil_e=veil, may_miss=3), sun=None
    )
    noise = {"read_noise_e": np.full((4, 1), 2.0), "gain_dn_per_e": np.full((4, 1), 1.0)}
    together = figures.snr_of_pixels(rows, light_x, np.ones(4), noise)
    monkeypatch.setattr(figures, "PIXELS_AT_ONCE", 1)  # one design at a time
    assert figures.snr_of_pixels(rows, light_x, np.ones(4), noise) == pytest.approx(together, rel=1e-15)
    seen = signal * light_x[:, None, None]
    every = seen + veil * light_x[:, None, None]
    expected = np.sort(seen / np.sqrt(2.0**2 + 1.0 / 12.0 + every), axis=2)[:, :, 3]
    assert together == pytest.approx(expected, rel=1e-12)
