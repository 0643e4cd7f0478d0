"""Colours of the page: one list for light and paper, one for dark."""

from __future__ import annotations

from collections.abc import Mapping

LIGHT: Mapping[str, str] = {
    "bg": "#f6f8f9", "panel": "#ffffff", "soft": "#edf2f5", "ink": "#16212b", "muted": "#51606d", "line": "#d5dde3",
    "accent": "#0a6480", "accent-soft": "#e2f0f4", "on-accent": "#ffffff",
    "good": "#1c6b40", "good-soft": "#e3f3e9", "warn": "#7d5200", "warn-soft": "#fbf0d9", "bad": "#a31f1f",
    "bad-soft": "#fbe6e4", "bar": "#5f9fb5", "grid": "#e1e7eb",
}  # fmt: skip
DARK: Mapping[str, str] = {
    "bg": "#0f151a", "panel": "#172028", "soft": "#1e2932", "ink": "#e7edf2", "muted": "#a3b3c0", "line": "#31404c",
    "accent": "#67c5e2", "accent-soft": "#183743", "on-accent": "#06212b",
    "good": "#74d39c", "good-soft": "#173626", "warn": "#f1bd59", "warn-soft": "#3a2e14", "bad": "#ff9188",
    "bad-soft": "#43201f", "bar": "#4f93ab", "grid": "#293641",
}  # fmt: skip
#: Colours of a third objective over two, from low to high: viridis without the end that fades into the ground.
SCALE_LIGHT = ["#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21908c", "#1d9a80"]
SCALE_DARK = ["#2f7f93", "#21918c", "#22a884", "#44bf70", "#7ad151", "#bddf26", "#fde725"]


def tokens(colours: Mapping[str, str]) -> str:
    """The colours as custom properties of CSS."""
    return " ".join(f"--{name}: {value};" for name, value in colours.items())
