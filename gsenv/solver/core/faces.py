"""Which of the two shapes of a contact has the face that its normal belongs to, and turns with."""

from __future__ import annotations

from typing import Any

from ..jit import njit

NO_FACE = 0  # corner on corner, edge on edge, round on round; or one whose place in the step is not known
FACE_OF_A = 1
FACE_OF_B = 2


@njit
def opposite_face(face: int) -> int:
    """Return the same after an exchange of the two shapes."""
    return face if face == NO_FACE else FACE_OF_A + FACE_OF_B - face


@njit
def face_and_other(contact: Any) -> tuple[int, int]:
    """Return the bodies of the shapes with and without the face of a contact that has one."""
    if contact.face == FACE_OF_A:
        return contact.body_a, contact.body_b
    return contact.body_b, contact.body_a
