"""What light scattered nearly forward still carries of the floor's detail, row by row; see `model.detail`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from uwopt.arrays import Array
from uwopt.forward.columns import Columns
from uwopt.forward.scene import Scattering, SceneOptics
from uwopt.forward.spectra import Contraction
from uwopt.forward.views import Views
from uwopt.model.detail import DetailTable, detail_gain, detail_table
from uwopt.model.sharpness import HALF_NYQUIST_CYC_PER_PX


@dataclass(frozen=True)
class DetailRows(Columns):
    """Of n designs in one scene; (n, 3) at near, nominal and far altitude."""

    scattered: Array  # (n, 3), b r of particles, straight down
    cycles_per_rad: Array  # (n, 3) of a cycle per largest pixel, in water
    texture_gain: Array  # (n,) of textures, on the SNR that information is reckoned from
    table: DetailTable

    def gain(
        self, frequency_cyc_per_px: Array, rows: Array | slice = slice(None),
        altitude: int | slice | Array = slice(None),
    ) -> Array:  # fmt: skip
        """Factor on the contrast of detail at frequencies (m, 3) or (m,), of some rows and altitudes; 1 or more."""
        return detail_gain(
            frequency_cyc_per_px * self.cycles_per_rad[rows, altitude], scattered=self.scattered[rows, altitude],
            table=self.table,
        )  # fmt: skip

    def hazier(self, ratio: Array) -> DetailRows:
        """The same in water whose particles scatter by a factor (n,) more, or less."""
        return replace(self, scattered=self.scattered * ratio[:, None], texture_gain=self.texture_gain**ratio)


def particles_of(scene: SceneOptics) -> Scattering | None:
    """What scatters nearly forward; molecules do not, and physics `paper` knows of none."""
    return next((one for one in scene.scattering if one.table is not None), None)


def shows_detail(contraction: Contraction, *, forward_veil: bool) -> bool:
    """Whether what is scattered nearly forward counts: where the forward veil does, with all orders of scattering."""
    return forward_veil and contraction.multiple and particles_of(contraction.scene) is not None


def detail_table_of(scene: SceneOptics) -> DetailTable:
    """chi of the scene's particles."""
    particles = particles_of(scene)
    assert particles is not None and particles.table is not None
    return detail_table(particles.table)


def detail_rows(scene: SceneOptics, view: Views, *, pixels: Array, scattering_per_m: Array) -> DetailRows:
    """Of images with so many pixels, in light whose colour the particles scatter by so much on average (n,) [1/m]."""
    range_m = np.array([scene.range_m[0], scene.range_m[scene.nominal], scene.range_m[-1]])
    return DetailRows(
        scattered=scattering_per_m[:, None] * range_m,
        cycles_per_rad=range_m / view.gsd_m,
        texture_gain=texture_gain(
            scene, area_m2=view.area_m2[:, 1], pixels=pixels, scattering_per_m=scattering_per_m
        ),
        table=detail_table_of(scene),
    )


def texture_gain(scene: SceneOptics, *, area_m2: Array, pixels: Array, scattering_per_m: Array | float) -> Array:
    """The factor that stands for a texture of all frequencies: at half the Nyquist frequency of the mean pixel (n,).

    area_m2 : (n,) of the footprint at the nominal altitude. Coarser detail has more, so that information is too low
    rather than too high: where b r = 1 by 2 to 10 % at an SNR of 30, by 20 % at an SNR of 3; about half of what would
    be missing without the factor.
    """
    range_m = float(scene.range_m[scene.nominal])
    pixel_m = np.sqrt(area_m2 / pixels)
    cycles_per_rad, scattered = HALF_NYQUIST_CYC_PER_PX * range_m / pixel_m, np.asarray(scattering_per_m) * range_m
    return detail_gain(cycles_per_rad, scattered=scattered, table=detail_table_of(scene))


def most_scattering_per_m(scene: SceneOptics) -> float:
    """No light's colour is scattered by more [1/m]."""
    return float(scene.particles_per_m().max())
