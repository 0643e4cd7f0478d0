"""The exit status of the command `uwopt`, and errors as messages: no person meets a traceback."""

from __future__ import annotations

import functools
import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import typer

from uwopt.cli import INTERRUPTED, NO_RESULT
from uwopt.errors import SolverError, UwoptError
from uwopt.results.version import __version__

if TYPE_CHECKING:
    from uwopt.results.front import FrontResult
    from uwopt.results.result import Result

DONE, DEFECT, BAD_INPUT, NOT_FEASIBLE, LIMIT_REACHED = 0, 1, 2, 3, 4
ENDS = {"infeasible": NOT_FEASIBLE, "stopped": LIMIT_REACHED, "interrupted": INTERRUPTED}  # by a result's own status
EXIT_STATUS = """\b
Exit status:
  0    done
  1    a defect of uwopt
  2    bad input or usage, or an output that cannot be written
  3    no feasible system, or none at the confidence asked for (the most certain is shown);
       evaluate --check: a requirement is missed, or the confidence
  4    stopped by a limit; the gap in the certificate is valid, or no system
       was found yet, as the first line says
  130  interrupted
"""


def command(work: Callable[..., int | None]) -> Callable[..., None]:
    """A command whose return value is the exit status, and whose errors become messages."""

    @functools.wraps(work)
    def guarded(*args: Any, **kwargs: Any) -> None:
        raise typer.Exit(exit_status(lambda: work(*args, **kwargs)))

    return guarded


def exit_status(work: Callable[[], int | None]) -> int:
    """Run a command; what goes wrong is told on the error stream."""
    try:
        return work() or DONE
    except (typer.Exit, typer.Abort, typer.BadParameter):
        raise
    except SolverError as fault:
        return print_notice(str(fault), DEFECT, fault)
    except UwoptError as fault:
        return print_notice(str(fault), BAD_INPUT, fault)
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        return DONE
    except KeyboardInterrupt:
        return print_notice(NO_RESULT, INTERRUPTED)
    except Exception as fault:  # the last door: a person must not meet a traceback
        return print_notice(defect_message(fault), DEFECT, fault)


def print_notice(message: str, status: int, fault: BaseException | None = None) -> int:
    """Print a message on the error stream, and the traceback if it is asked for; returns the status."""
    from uwopt.report.text.console import discard_rest
    from uwopt.report.text.formats import in_encoding, printable

    stream = sys.stderr
    if stream is not None:
        if fault is not None and os.environ.get("UWOPT_DEBUG") == "1":
            import traceback

            traceback.print_exception(fault, file=stream)
        try:
            print(in_encoding(printable(message), stream.encoding or "utf-8"), file=stream, flush=True)
        except OSError:  # a full disk behind it, or nobody reads it any more
            discard_rest(stream)
    return status


def defect_message(fault: Exception) -> str:
    """What happened, where, and how to report it."""
    frame, place = fault.__traceback__, ""
    while frame is not None:
        module = str(frame.tb_frame.f_globals.get("__name__", ""))
        if module.startswith("uwopt"):
            place = f" in {module} line {frame.tb_lineno}"
        frame = frame.tb_next
    what = " ".join(str(fault).split())[:300]
    return (
        f"uwopt {__version__}: a defect of uwopt, not of your files: {type(fault).__name__}{place}: {what}\n"
        "Please report it with the command and the files; UWOPT_DEBUG=1 shows the traceback."
    )


def was_interrupted(result: Result | FrontResult) -> bool:
    """Whether the result holds only what was there when a person interrupted."""
    return any(warning.code == "interrupted" for warning in result.warnings)


def result_status(result: Result, *, check: bool = False) -> int:
    """The exit status that a result asks for."""
    if was_interrupted(result):
        return INTERRUPTED
    if result.audit and not result.audit.get("passed", True):
        return print_notice(
            "uwopt: the audit found a better system; the certificate is wrong, please report it.", DEFECT
        )
    if result.status == "violated":
        return NOT_FEASIBLE if check else DONE
    known = result.confidence
    if known is not None and not known.enough and result.status != "stopped" and (check or result.command == "solve"):
        return NOT_FEASIBLE
    return ENDS.get(result.status, DONE)


def front_status(result: FrontResult) -> int:
    """The exit status that a front asks for."""
    if was_interrupted(result):
        return INTERRUPTED
    return ENDS.get(result.status, DONE)
