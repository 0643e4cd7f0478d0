"""How the process keeps memory that arrays have left.

Figures of thousands of designs go through some hundred arrays of a hundred kilobytes. Where each of them is asked of
the system and given back, its pages are cleared every time, which costs as much as what is worked out in them.
"""

from __future__ import annotations

import numpy as np

LARGEST_BYTES = 32_000_000  # just below the most that glibc learns to keep: mallopt(3), M_MMAP_THRESHOLD


def keep_freed_memory() -> None:
    """Give an array back that is larger than any block: glibc then keeps what is freed up to twice as much.

    Nothing is written into it, so that it takes no memory. Other libraries than glibc learn nothing from it.
    """
    np.empty(LARGEST_BYTES // 8)
