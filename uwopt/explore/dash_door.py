"""The one module that imports Dash, so that the rest of the page can be read, and tested, as plain Python."""

from __future__ import annotations

from dash import Dash, Input, Output, State, ctx, dcc, html, no_update
from dash.exceptions import PreventUpdate

__all__ = ["Dash", "Input", "Output", "PreventUpdate", "State", "ctx", "dcc", "html", "no_update"]
