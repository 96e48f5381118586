"""The paragraphs of the pages that describe how the points were measured."""

from __future__ import annotations

from collections.abc import Sequence

TIMES = """\
Times are CPU times of the step calls in us per simulated second, as medians of repeated runs. Building, compiling and
reading are not counted, and garbage collection is off."""

ERRORS = """\
The error is the same function of the trajectory for every engine (`benchmarks/accuracy/errors.py`, in 3D also
`errors3d.py`): errors that an engine reports itself are not used. Errors are relative, or in m where the
title says so."""

SHARED_FAMILIES = """\
- bounces: the largest relative error of the first three apexes.
- cradle: the largest error of the highest angle of the balls that should swing out, or the largest angle of a ball that
  should rest, divided by the starting angle.
- tower, mass_ratio, pyramid: the deepest overlap at any time (exact, from the poses) or the largest error of a
  layer's mean height at the end divided by the number of layers up to it, whichever is larger. A tower that drifts
  sideways by 1 cm or still moves at 1 cm/s at the end has failed. Sleeping is off except where the title says "may
  sleep"."""


def method(dim: int, engines: Sequence[str]) -> str:
    """Return the paragraphs of a dimension, with one on each engine in ``engines`` that is built from its sources."""
    return "\n\n".join([METHOD[dim], *(paragraph(text) for name, text in BUILT.items() if name in engines)])


def paragraph(text: str) -> str:
    """Return the text in one line."""
    return " ".join(text.split())


PLANAR = "\n\n".join(
    (
        paragraph(
            f"""
{TIMES} A loop calls the C function of Box2D and pymunk once per step (for an empty world this takes 0.6 us in Box2D
and 0.3 us in pymunk); gsenv takes all steps in one call. Each engine gets the same bodies, masses, friction,
restitution and initial state; Box2D and pymunk do not get shapes that cannot touch anything. {ERRORS}
"""
        ),
        f"""\
- pendulum, chain_period: the relative error of the mean period over all whole periods of 10 s, for the chain that of
  its lowest rod.
- slide_to_roll, rolling, incline: the largest deviation from the law of motion at any time, divided by the final
  distance; in m where the block should stay.
{SHARED_FAMILIES}
- heavy_chain: the larger of the hinge gap divided by the link's length and the energy error; double_pendulum: the
  energy error. Both are the largest at any time; energies are divided by m g L of the whole chain.
- spring: the largest distance from the damped oscillator's closed form in five periods, divided by the amplitude.""",
        paragraph(
            """
The columns of settings list, for gsenv, the solver, steps per second x substeps and the tolerance, or a fidelity, and
"joint coordinates" where these solved a linkage; other settings solve it by rows. Fidelities use joint coordinates,
which are the default. They list, for
Box2D, the steps per second and the velocity and position iterations; for pymunk, the steps per second, the iterations,
the collision_slop in m, and the part of an overlap or joint gap that is left after 1/60 s. Box2D's polygons have a skin
of 1 cm and overlap by up to 5 mm by design. Its shapes are therefore made smaller by the skin, or ("slop taken off") by
the skin less half the overlap, so that the true shapes just touch in the state that Box2D aims at. "lengths x 10" gives
it a larger world, which makes its fixed lengths and speeds relatively smaller. Its warm starting is on and its
continuous physics off.
"""
        ),
    )
)

SPATIAL = "\n\n".join(
    (
        paragraph(
            f"""
{TIMES} gsenv and MuJoCo take all steps in one call; a loop calls the function of PyBullet and of Rapier once per step.
Each engine gets the same bodies, masses, inertias, friction, restitution and initial state. Linkages are trees of ball
joints in MuJoCo and links of Featherstone's algorithm in PyBullet; in both, joints cannot open. {ERRORS}
"""
        ),
        f"""\
- tumbling: the largest relative error, at any time, of the energy, of the angular momentum vector, and of the times at
  which the angular velocity about the middle axis changes sign.
- gyroscope: the relative error of the mean angular velocity of its arm in 5 s. It was not run in PyBullet.
- slide_to_roll, rolling: the largest deviation from the law of motion at any time, divided by the final distance.
- incline: a block on a plane that falls by 35° or 20° in a direction 0° to 45° from the x axis. The error is the
  distance from where it should be, sideways too, divided by the final distance; in m where it should stay.
{SHARED_FAMILIES}
- heavy_chain: the larger of the joint gap divided by the link's length and the energy error; two_rods: the energy
  error. Both are the largest at any time; energies are divided by m g L of the whole chain.
- balls: the deepest overlap at any of 60 samples per second in 3 s.""",
        paragraph(
            """
The columns of settings list, for gsenv, the solver, steps per second x substeps and the tolerance, or a fidelity, and
"joint coordinates" where these solved a linkage; other settings solve it by rows. Fidelities use joint coordinates,
which are the default. They list, for
MuJoCo, the steps per second, integrator, friction cone, dmin and dmax of solimp, solver and iterations where they are
not 100 of Newton's, noslip iterations, impratio, and solref's time constant in timesteps (two, its lower limit, where
none is given); for PyBullet, the steps per second, iterations and erp. MuJoCo has no coefficient of restitution: where
balls bounce, its contacts are springs with the damping that gives this coefficient (solref in its direct form), and a
bounce takes contact_steps timesteps. In PyBullet, "maximal" are separate rigid bodies, the others links of
Featherstone's algorithm. For Rapier, which computes in single precision, they list the steps per second x substeps.
"stiff" sets the frequency of its contacts to an eighth of the substeps' rate and to a quarter on static bodies, "half"
to half of these with less damping; otherwise they are its defaults of 30 and 60 Hz. "cone" is Coulomb's friction at
each point in place of one for the manifold.
"""
        ),
    )
)

SOFT_STEPS = """\
Its settings list the steps per second x substeps. "stiff" sets the frequencies of contacts and joints to the most that
it allows, an eighth and a quarter of the substeps' rate; without it they are its defaults of 30 and 60 Hz, which allow
overlaps however small the substeps are. "lively" is stiff with less damping, and "not recycled" finds a contact's
points anew in each step, though the pair has moved by less than 5 cm. Its threshold of restitution is 0, and its
continuous collision is off. All steps are taken in one call."""

BUILT = {
    "Box2D v3": f"""
Box2D v3 is built from its sources for one thread, with its vector instructions or, in the settings that say "scalar",
without. Its polygons have no skin. {SOFT_STEPS}
""",
    "Box3D": f"""
Box3D is built from its sources for one thread, as it builds by default. It has no cylinders: these are prisms with 32
sides, the most that its function for them makes. {SOFT_STEPS}
""",
}

METHOD = {2: PLANAR, 3: SPATIAL}
LENIENT = (
    "These tables have the same scenes without the limits on drift and final speed, so that only the deepest overlap"
    " and the mean heights of the layers count."
)
