"""Any text: all characters that UTF-8 can write.

Hypothesis' own `text()` draws the same ones, but asks the codec of each of a million: 2 s in every process of a clean
clone.
"""

from __future__ import annotations

from hypothesis import strategies as st

ANY_TEXT = st.characters(exclude_categories=["Cs"])
