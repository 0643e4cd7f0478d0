"""A Dask scheduler and workers as processes of their own on loopback, forked from one that has loaded their program.

`python dask_processes.py COUNT FOLDER` prints the scheduler's address and the workers' process ids as JSON, and ends
them when its input closes; what they keep lies in the folder.
"""

from __future__ import annotations

import asyncio
import json
import logging
import os
import signal
import sys
from collections.abc import Callable, Coroutine
from typing import Any

import dask
from distributed import Scheduler, Worker

import uwopt.sweeps.work  # noqa: F401 - loaded once for all

LOOPBACK, WEB = "tcp://127.0.0.1:0", "127.0.0.1:0"


async def scheduler(tell: int) -> None:
    """Tell its address into a pipe, then serve."""
    async with Scheduler(host=LOOPBACK, dashboard_address=WEB) as made:
        os.write(tell, made.address.encode())
        os.close(tell)
        await made.finished()


async def worker(address: str) -> None:
    """Serve a scheduler with one thread."""
    folder = sys.argv[2]
    async with Worker(
        address, nthreads=1, host=LOOPBACK, dashboard_address=WEB, local_directory=folder
    ) as made:
        await made.finished()


def forked(serve: Callable[[], Coroutine[Any, Any, None]]) -> int:
    """A process that serves; its id."""
    child = os.fork()
    if child:
        return child
    asyncio.run(serve())
    os._exit(0)


def main() -> None:
    """Start them, tell of them, wait, end them."""
    dask.config.set({"temporary-directory": sys.argv[2]})
    logging.disable(logging.WARNING)
    ear, tell = os.pipe()
    children = [forked(lambda: scheduler(tell))]
    os.close(tell)
    address = os.read(ear, 1000).decode()
    children += [forked(lambda: worker(address)) for _ in range(int(sys.argv[1]))]
    print(json.dumps({"address": address, "workers": children[1:]}), flush=True)
    sys.stdin.read()
    for child in children:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


if __name__ == "__main__":
    main()
