"""The settings card as an HTML page that prints on one sheet, and as text."""

from __future__ import annotations

from uwopt.errors import ResultError
from uwopt.report.card.blocks import SettingsCard, settings_card
from uwopt.report.page.html_file import rendered
from uwopt.report.text.looked_at import in_page, wording
from uwopt.results.result import Result


def card_of(result: Result, name: str) -> SettingsCard:
    """The card of a result; raises ResultError where it has no design."""
    made = settings_card(result)
    if made is None:
        raise ResultError(f"{name}: holds no system, so there is nothing to set; solve a mission that has one.")
    return made


def card_html(result: Result, card: SettingsCard) -> str:
    """The card as a page."""
    page = rendered(
        "card.html", (), {"figures": {}}, title="Settings card", name=card.name, card=card, version=result.uwopt_version
    )
    return in_page(page, wording(result.mission))
