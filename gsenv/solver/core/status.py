"""Status codes that a step returns to the World that called it."""

from __future__ import annotations

OK = 0
MORE_PAIRS = 1  # the buffer of pairs is too small
MORE_CONTACTS = 2  # the buffer of contacts is too small
BAD_CONTROL = 3  # a control is NaN or infinite
NOT_FINITE = 4  # all steps are taken; a position or velocity is NaN or infinite
