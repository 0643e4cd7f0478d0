"""The settings card as an HTML page that prints on one sheet, and as text."""

from __future__ import annotations

from uwopt.errors import ResultError
from uwopt.report.card.blocks import SettingsCard, settings_card
from uwopt.report.page.html_file import rendered
from uwopt.report.text.looked_at import in_page, wording_of
from uwopt.results.result import Result

LEGEND = "A setting may be off as far as told while all others stay; brightness apart, which gain can mend."
FOOT = "settings card. Computed, not yet dived: take a test image first."


def card_of(result: Result, name: str) -> SettingsCard:
    """The card of a result; raises ResultError where it has no design."""
    made = settings_card(result)
    if made is None:
        raise ResultError(f"{name}: holds no system, so there is nothing to set; solve a mission that has one.")
    return made


def card_html(result: Result, card: SettingsCard) -> str:
    """The card as a page."""
    page = rendered(
        "sheet.html", (), {"figures": {}}, title="Settings card", name=card.name, version=result.uwopt_version,
        lead=card.hardware, said=f"{card.verdict} {LEGEND}", blocks=card.blocks, foot=FOOT,
    )  # fmt: skip
    return in_page(page, wording_of(result))
