"""Pressure hulls: the wall that a tube, a sphere and a flat end cap need against the water outside."""

from __future__ import annotations

import math

SEAWATER_KG_M3 = 1025.0
GRAVITY_M_S2 = 9.81


def pressure_pa(depth_m: float) -> float:
    """Pressure of the water above what stands in the air inside.

        p = rho g d                                                            rho = 1025 kg/m^3

    Parameters
    ----------
    depth_m : [m], from 0

    Returns
    -------
    [Pa]. Valid to 1 % at 1 km; at 6 km water is 3 % denser than at the surface, which safety factors hold.
    """
    return SEAWATER_KG_M3 * GRAVITY_M_S2 * depth_m


def tube_wall_mm(
    inner_diameter_mm: float, *, pressure_pa: float, yield_pa: float, young_pa: float, poisson: float
) -> float:
    """Least wall of a long tube that neither buckles nor yields at this pressure.

        buckles:  p = 2 E / (1 - nu^2) (t / D_m)^3,          D_m = D_i + t
        yields:   p = sigma (D_o^2 - D_i^2) / (2 D_o^2),     D_o = D_i + 2 t

    Parameters
    ----------
    inner_diameter_mm : [mm]
    pressure_pa : [Pa], safety included
    yield_pa, young_pa, poisson : of the material [Pa], [Pa], 1

    Returns
    -------
    [mm]; inf where no wall of this material holds.

    Notes
    -----
    Valid for: tubes of any length (end caps stiffen a short one, so the wall errs to the safe side), round ones, long
    loads within the elastic range. Yield by Tresca at the inner face, where the hoop stress is largest.

    References
    ----------
    Timoshenko & Gere, Theory of Elastic Stability (ring under pressure, plane strain); Lame's thick cylinder.
    """
    slender = ((1.0 - poisson**2) * pressure_pa / (2.0 * young_pa)) ** (1.0 / 3.0)
    share = 1.0 - 2.0 * pressure_pa / yield_pa
    if slender >= 1.0 or share <= 0.0:
        return math.inf
    return max(inner_diameter_mm * slender / (1.0 - slender), 0.5 * inner_diameter_mm * (share**-0.5 - 1.0))


def cap_thickness_mm(diameter_mm: float, *, pressure_pa: float, yield_pa: float, poisson: float) -> float:
    """Thickness of a flat round end cap, simply supported at its rim.

        sigma = 3 (3 + nu) / 8  p (a / t)^2,      a: radius

    Parameters
    ----------
    diameter_mm : free span [mm]
    pressure_pa : [Pa], safety included
    yield_pa, poisson : of the material [Pa], 1

    Returns
    -------
    [mm]. Valid for: small deflections; a rim that is clamped needs less.

    References
    ----------
    Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells, circular plates.
    """
    return 0.5 * diameter_mm * math.sqrt(3.0 * (3.0 + poisson) * pressure_pa / (8.0 * yield_pa))


def tube_material_mm3(
    inner_diameter_mm: float, *, inner_length_mm: float, wall_mm: float, cap_mm: float
) -> float:
    """Volume of the material of a tube with two flat ends.

        V = pi / 4 ((D_o^2 - D_i^2) L + 2 D_o^2 t_cap)

    Parameters
    ----------
    inner_diameter_mm, inner_length_mm, wall_mm, cap_mm : [mm]

    Returns
    -------
    [mm^3]. Valid for: two whole caps; the ring that holds a port instead of one weighs about as much.

    References
    ----------
    Geometry.
    """
    outer = inner_diameter_mm + 2.0 * wall_mm
    return math.pi / 4.0 * ((outer**2 - inner_diameter_mm**2) * inner_length_mm + 2.0 * outer**2 * cap_mm)
