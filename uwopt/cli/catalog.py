"""The commands `uwopt catalog ...`: what can be bought, and checks of own files."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from uwopt.cli.status import BAD_INPUT, DONE, command, print_notice

catalog_app = typer.Typer(
    help="What can be bought: list and show parts, check own files, print templates.",
    short_help="List, show and check parts.",
    rich_markup_mode=None,
    no_args_is_help=True,
)


class KindName(StrEnum):
    """Kinds of parts."""

    camera = "camera"
    lens = "lens"
    port = "port"
    light = "light"
    housing = "housing"
    complete = "complete"


FilesOption = Annotated[
    list[str] | None,
    typer.Option("--file", metavar="FILE", help="Own parts (CSV or YAML) to add; may be repeated."),
]


@catalog_app.command("list")
@command
def list_command(
    pattern: Annotated[
        str,
        typer.Argument(metavar="PATTERN", help="Plain piece of an id or maker, or a glob such as 'kowa*'."),
    ] = "",
    kind: Annotated[KindName | None, typer.Option(help="Only parts of this kind.")] = None,
    excluded: Annotated[
        bool, typer.Option("--excluded", help="Parts that no search uses, with the reasons.")
    ] = False,
    files: FilesOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """List the parts of the catalogue."""
    from uwopt.catalog.listing import list_parts
    from uwopt.report.text.console import print_blocks, print_json

    catalog = loaded_catalog(files)
    kind_name: Any = None if kind is None else kind.value
    lines = list_parts(catalog, kind_name, pattern, excluded)
    if not lines and pattern and not list_parts(catalog, kind_name, pattern, not excluded):
        raise_unknown(pattern, catalog, kind_name)
    if as_json:
        print_json(lines)
    elif lines:
        from uwopt.report.text.parts import part_list_blocks

        print_blocks(part_list_blocks(lines))
    else:
        print_notice(
            "no such part is left out."
            if excluded
            else "all such parts are left out; --excluded lists them.",
            DONE,
        )


@catalog_app.command("show", short_help="Show all that is known of a part.")
@command
def show_command(
    part: Annotated[
        str, typer.Argument(metavar="ID", help="Id of a part, as `uwopt catalog list` prints it.")
    ],
    files: FilesOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """Show all that is known of a part: values, ranges, how they are known, and from where."""
    from uwopt.catalog.listing import show_part
    from uwopt.report.text.console import print_blocks, print_json

    catalog = loaded_catalog(files)
    lines, exclusions = show_part(catalog, part)
    if as_json:
        print_json({"id": catalog.part(part).id, "fields": lines, "excluded": exclusions})
        return
    from uwopt.report.text.parts import part_blocks

    print_blocks(part_blocks(catalog.part(part).id, lines, exclusions))


@catalog_app.command("check", short_help="Check own files row by row.")
@command
def check_command(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE", help="Parts, prices or spectra (CSV or YAML).")
    ],
) -> int:
    """Check own files row by row; exit with status 2 when one has a fault."""
    from uwopt.catalog.checkfile import file_report
    from uwopt.report.text.console import print_blocks
    from uwopt.report.text.parts import check_blocks

    paths = [*map(Path, files)]
    reports = [file_report(path, [other for other in paths if other != path]) for path in paths]
    for report in reports:
        if report.content == "unreadable":
            print_notice("\n".join(report.faults), BAD_INPUT)
        else:
            print_blocks(check_blocks(report))
    return DONE if all(report.ok for report in reports) else BAD_INPUT


@catalog_app.command("stale", short_help="List parts whose facts are old or missing.")
@command
def stale_command(
    results: Annotated[
        list[str] | None,
        typer.Argument(metavar="[RESULT]", help="Results that --out wrote: only parts they rest on, most used first."),
    ] = None,
    months: Annotated[int, typer.Option(min=1, help="From how many months on a price is old.")] = 12,
    files: FilesOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """List parts whose price is old, undated or not quoted, those without a source, or that nobody was seen to sell.

    Those come first that most recommendations rest on: of the results named, else of the missions in problems/.
    """
    from uwopt.catalog.stale import orders_by_part, stale_rows
    from uwopt.report.text.console import print_blocks, print_json

    uses = recommended_in(results) if results else orders_by_part()
    rows = stale_rows(loaded_catalog(files), uses, whole=not results, months=months)
    if as_json:
        print_json(rows)
    elif rows:
        from uwopt.report.text.parts import stale_blocks

        print_blocks(stale_blocks(rows, "" if results else "used: orders of the missions that come with uwopt"))
    else:
        print_notice("nothing there is old or missing.", DONE)


@catalog_app.command("update", short_help="Add or change parts, with a record of it.")
@command
def update_command(
    sources: Annotated[
        list[str],
        typer.Argument(metavar="SOURCE", help="Files or folders of parts or prices (CSV, YAML): what is new."),
    ],
    log: Annotated[
        str, typer.Option("--out", metavar="FILE", help="The log of changes to add to; made where there is none.")
    ] = "catalogue-changes.csv",
    source: Annotated[str, typer.Option(help="Where rows are from that do not say it (source_url).")] = "",
    date: Annotated[str, typer.Option(help="Day of the change, YYYY-MM-DD; today unless given.")] = "",
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Check and list the changes, write nothing.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> None:
    """Add parts to the catalogue or change theirs: all rows are checked first, then every cell that is new is logged.

    A row with the id of a part changes the cells that it fills (- clears one); another id is a new part. The log is
    itself a file of parts: name it in a mission's catalog.files, or with --file here.
    """
    from datetime import date as calendar

    from uwopt.catalog.changes import log_text
    from uwopt.catalog.update import planned
    from uwopt.report.text.console import print_blocks, print_json
    from uwopt.report.text.parts import change_blocks
    from uwopt.report.write import write_text

    target = Path(log)
    plan = planned([Path(name) for name in sources], target, date=date or calendar.today().isoformat(), source=source)
    if plan.changes and not dry_run:
        write_text(log_text(plan.log), target)
    if as_json:
        print_json(plan.changes)
    elif plan.changes:
        print_blocks(change_blocks(plan.changes, "" if dry_run else str(target)))
    else:
        print_notice("nothing there is new.", DONE)


def recommended_in(files: list[str]) -> dict[str, int]:
    """How often each part is recommended in results and fronts, by id."""
    from collections import Counter

    from uwopt.results.front import FrontResult
    from uwopt.results.reading import read_result

    found: Counter[str] = Counter()
    for name in files:
        result = read_result(name)
        if isinstance(result, FrontResult):
            designs = [point.design for point in result.points]
        else:
            designs = [result.recommendation] if result.recommendation else []
        found.update(part.id for design in designs for part in design.hardware.named.values())
    return dict(found)


@catalog_app.command("template", short_help="Print a file to start from.")
@command
def template_command(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="camera, lens, port, light, housing, complete, prices, or a spectrum.")
    ],
) -> None:
    """Print a file to start from: comments on every column, the header, an example row."""
    from uwopt.catalog.checkfile import template
    from uwopt.report.text.console import print_text

    print_text(template(kind.strip().casefold()).rstrip("\n"))


def loaded_catalog(files: list[str] | None) -> Any:
    """The built-in catalogue, with own parts."""
    from uwopt.catalog.load import read_catalog

    return read_catalog(files or ())


def raise_unknown(pattern: str, catalog: Any, kind: Any) -> NoReturn:
    """A pattern that fits nothing is a fault; near names help."""
    from uwopt.catalog.catalogue import near_names
    from uwopt.catalog.records import KINDS
    from uwopt.errors import CatalogError

    parts = [part for each in KINDS if kind in (None, each) for part in catalog.parts(each)]
    near = near_names(pattern, [name for part in parts for name in (part.manufacturer, part.id)])
    hint = f"did you mean {', '.join(near)}?" if near else "`uwopt catalog list` prints all ids."
    raise CatalogError(f"no {kind or 'part'} fits {pattern!r}; {hint}")
