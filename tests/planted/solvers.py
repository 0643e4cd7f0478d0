"""Planted defects of the search: bounds, rules that discard, settings, fronts."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = ()
