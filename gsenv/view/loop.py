"""The loop of an interactive window."""

from __future__ import annotations

import time

from gsenv.view.pacing import Pacer
from gsenv.view.session import Session
from gsenv.view.simulation import Simulation
from gsenv.view.window import Size, Window

FPS = 60.0  # at most
LONGEST_PAUSE = 0.1  # s: a longer time between two frames, such as that of a moved window, does not count in full


def run(simulation: Simulation, size: Size, *, paused: bool = False) -> None:
    """Open a window of this size in px on a simulation, until the user quits or closes it.

    Raises:
        ImportError: pygame-ce is missing.
        WindowError: there is no display.
    """
    session = Session(simulation, size, paused=paused)
    session.picture()  # before the window opens, because kernels may have to be compiled
    with Window(simulation.title, size) as window:
        show(session, window)


def show(session: Session, window: Window) -> None:
    """Show a session in a window until the user quits or closes the window."""
    pacer = Pacer(FPS)
    last = time.perf_counter()
    while session.running:
        for event in window.take_events():
            session.handle(event)
        if window.size != session.screen.size:
            session.screen.size = window.size
        now = time.perf_counter()
        session.tick(min(now - last, LONGEST_PAUSE))
        last = now
        if session.needs_picture:
            window.show(session.picture())
        pacer.wait()
