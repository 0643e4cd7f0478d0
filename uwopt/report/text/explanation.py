"""What `uwopt explain` prints: why nothing fits and what would help, or else which system does."""

from __future__ import annotations

from collections.abc import Iterator

from uwopt.report.text import formats, words
from uwopt.report.text.layout import Block, Text, block, sentence
from uwopt.report.text.nothing_fits import infeasible_block, miss_sentence, nearest_title
from uwopt.report.text.prices import price_blocks
from uwopt.report.text.tables import nearest_miss
from uwopt.report.text.verdict import system_text
from uwopt.results.design import PRACTICE_IN_VAIN, PRACTICE_UNTRIED, PRACTICE_WOULD_YIELD
from uwopt.results.result import Result

OF_PRACTICE = (PRACTICE_WOULD_YIELD, PRACTICE_IN_VAIN, PRACTICE_UNTRIED)


def explanation_blocks(result: Result) -> Iterator[Block | Text]:
    """The explanation block by block."""
    name = formats.one_line(result.mission.get("name") or "mission", 80)
    if result.best is not None:
        parts = ", ".join(words.as_bought([part.id for part in result.best.hardware.named.values()]))
        said = f"Something fits: {formats.one_line(parts, 300)}. uwopt solve says how sure that is, and how to set it."
        yield block(name, [sentence(said)])
        yield from price_blocks(result)
    else:
        said = words.as_sentence(words.status_sentence(result))
        told = [words.as_sentence(note.message) for note in result.warnings if note.code in OF_PRACTICE]
        yield block(name, [sentence(one) for one in (said, *told)])
        yield infeasible_block(result)
        miss = nearest_miss(result)
        if miss is not None and (note := miss_sentence(result, system_text(miss))) is not None:
            yield block(nearest_title(result), [note])
    above = () if result.infeasible is None else ("time", *OF_PRACTICE)
    notes = [note for note in result.warnings if note.code not in above]
    if notes:
        yield block("Notes", [sentence("- " + words.as_sentence(words.note_text(note))) for note in notes])
    yield sentence(f"Took {words.run_time_sentence(result.timing_s)}.", "dim")
