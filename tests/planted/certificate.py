"""Planted defects of the certificate: account, lower bounds, audit."""

from __future__ import annotations

from planted.defect import Defect

DEFECTS: tuple[Defect, ...] = ()
