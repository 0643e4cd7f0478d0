"""Planted defects of margins, objectives and evaluation."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = ()
