"""How the points were measured, as the pages say it."""

from __future__ import annotations

TIMES = """\
Times are CPU us of the step calls per simulated second, median of repeated runs; building, compiling and
reading are not counted, garbage collection is off."""

ERRORS = """\
The error is the same function of the trajectory for every engine (`benchmarks/accuracy/errors.py`, in 3D also
`errors3d.py`): what an engine says about itself does not enter it. Numbers are relative, or in m where the title says
so."""

SHARED_FAMILIES = """\
- bounces: largest relative error of the first three apexes.
- cradle: worst error of the highest angle of the balls that should swing out, or angle of a ball that should
  rest, over the starting angle.
- tower, mass_ratio, pyramid: deepest overlap at any time (exact, from the poses) or mean height error of a layer per
  layer, whichever is larger. A tower that drifts sideways by 1 cm or still moves at 1 cm/s at the end
  has failed. Sleeping is off except where the title says "may sleep"."""


def paragraph(text: str) -> str:
    """The text in one line."""
    return " ".join(text.split())


PLANAR = "\n\n".join(
    (
        paragraph(
            f"""
{TIMES} A peer's step is one call of its C function from a bare loop (for an empty world 0.3 us in pymunk, 0.6 us in
Box2D); gsenv takes all steps in one call. Each engine gets the same bodies, masses, friction, restitution and start;
shapes that cannot touch anything are left out for the peers. {ERRORS}
"""
        ),
        f"""\
- pendulum, chain_period: relative error of the period, over all whole periods of 10 s; of the lowest rod of the chain.
- slide_to_roll, rolling, incline: largest deviation from the law of motion at any time, over the final distance; in m
  where the block should stay.
{SHARED_FAMILIES}
- heavy_chain: worst of hinge gap over link length and energy error; double_pendulum: energy error; both at any time,
  energies over m g L of the whole chain.
- spring: largest distance from the damped oscillator's closed form over five periods, over the amplitude.""",
        paragraph(
            """
Settings. gsenv: solver, steps per second x substeps, tolerance; or a fidelity. Box2D: steps per second,
velocity/position iterations. Its polygons have a skin of 1 cm and overlap by up to 5 mm by design: shapes
are made smaller by the skin, or ("slop taken off") by the skin less half the overlap, so that the true
shapes just touch in the state that Box2D aims at; "lengths x 10" gives it a larger world, which makes its fixed
lengths and speeds smaller. Warm starting is on, continuous physics off. pymunk: steps per second,
iterations, collision_slop in m, and the part of an overlap or joint gap that is left after 1/60 s.
"""
        ),
    )
)

SPATIAL = "\n\n".join(
    (
        paragraph(
            f"""
{TIMES} gsenv and MuJoCo take all steps in one call, PyBullet one in a call of its C function from a bare loop. Each
engine gets the same bodies, masses, inertias, friction, restitution and start. Linkages are trees of ball joints in
MuJoCo and Featherstone's links in PyBullet; the joints of both cannot open. {ERRORS}
"""
        ),
        f"""\
- tumbling: worst of the relative errors of the times at which the angular velocity about the middle axis changes sign,
  of the energy and of the angular momentum vector, at any time.
- gyroscope: relative error of the mean speed at which its arm goes around in 5 s. Not in PyBullet.
- slide_to_roll, rolling: largest deviation from the law of motion at any time, over the final distance.
- incline: a block on a plane that falls by 35° or 20° in a direction 0° to 45° from the x axis; distance from where it
  should be, sideways too, over the final distance; in m where it should stay.
{SHARED_FAMILIES}
- heavy_chain: worst of joint gap over link length and energy error; two_rods: energy error; both at any time, energies
  over m g L of the whole chain.
- balls: deepest overlap at any of 60 samples per second of 3 s.""",
        paragraph(
            """
Settings. gsenv: solver, steps per second x substeps, tolerance; or a fidelity. MuJoCo: steps per second, integrator,
friction cone, dmin and dmax of solimp, solver and iterations where they are not Newton's 100, noslip iterations,
impratio, solref's time constant in timesteps (two, its lower limit, where nothing is said). MuJoCo has no coefficient
of restitution: where balls bounce, contacts are springs with the damping that gives it (solref in its
direct form), and a bounce takes contact_steps timesteps. PyBullet: steps per second, iterations, erp; "maximal" are
plain rigid bodies, the others Featherstone's.
"""
        ),
    )
)

METHOD = {2: PLANAR, 3: SPATIAL}
LENIENT = (
    "The same without the limits on drift and final speed: only the deepest overlap and the mean heights of the layers "
    "count."
)
