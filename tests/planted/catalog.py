"""Planted defects of the catalogue: tables, prices, records, compatibility."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = ()
