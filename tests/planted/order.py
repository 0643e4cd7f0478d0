"""Defects in what a buyer works with: workbooks, cards, comparisons, tenders."""

from planted.defect import Defect

BOOK = "tests/report/order/test_bom_book.py"

DEFECTS = (
    Defect(
        name="control sign before a formula",
        file="uwopt/report/order/book.py",
        old="    return defused(kept)[:MOST_CHARS]",
        new="    return defused(value)[:MOST_CHARS].replace('\\x07', '')",
        test=f"{BOOK}::test_no_text_of_a_file_becomes_a_formula",
    ),
    Defect(
        name="owned pieces are paid in every system",
        file="uwopt/report/order/bom_book.py",
        old='f"=MAX(0,F{n}*{SYSTEMS}-G{n})"',
        new='f"=(F{n}-G{n})*{SYSTEMS}"',
        test=f"{BOOK}::test_totals_follow_systems_quotes_tax_and_what_is_filled_in",
    ),
    Defect(
        name="a quote does not take the price's place",
        file="uwopt/report/order/bom_book.py",
        old="""f'=IF(L{n}<>"",H{n}*L{n},IF""",
        new="""f'=IF(L{n}="",0,0)+IF(1=0,0,IF""",
        test=f"{BOOK}::test_totals_follow_systems_quotes_tax_and_what_is_filled_in",
    ),
    Defect(
        name="high ends are summed for low ones",
        file="uwopt/report/order/bom_book.py",
        old='((16, "I"), (17, "J"), (18, "K"))',
        new='((16, "I"), (17, "K"), (18, "J"))',
        test=f"{BOOK}::test_totals_are_the_result_s_and_no_cell_is_an_error",
    ),
)
