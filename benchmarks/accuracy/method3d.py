"""What the spatial report says of how it was measured."""

METHOD3D = """\
Times are CPU us of the step calls per simulated second, median of repeated runs; building, compiling and
reading are kept out, garbage collection is off. gsenv and MuJoCo take all steps in one call, PyBullet one in a
call of its C function from a bare loop. Each engine gets the same bodies, masses, inertias, friction, restitution and
start, nothing sleeps. Linkages are trees of ball joints in MuJoCo and Featherstone's links in PyBullet, both of whose
joints cannot open. The error is the same function of the trajectory for each (`benchmarks/accuracy/errors.py`,
`errors3d.py`): what an engine says of itself does not enter it. Numbers are relative, or in m where the title says so.

- 4: worst of the relative errors of the times at which the spin about the middle axis changes sign, of the energy
  and of the angular momentum vector, at any time.
- 5: relative error of the mean speed at which a gyroscope's arm goes around in 5 s. Not in PyBullet.
- 6, 7: largest deviation from the law of motion at any time, over the final distance.
- 8: a block on a plane that falls by 35° or 20° towards 0° to 45° from the x axis; distance from where it should
  be, sideways too, over the final distance; creep in m.
- 10: largest relative error of the first three apexes.
- 11: worst error of the highest angle of the balls that should swing out, or angle of a ball that should
  rest, over the starting angle.
- 14, 15, 16: deepest overlap at any time (exact, from the poses) or mean height error of a layer per
  layer, whichever is larger. A tower that drifts sideways by 1 cm or still moves at 1 cm/s at the end
  has failed.
- 17: worst of joint gap over link length and energy error; 18: energy error; at any time, over m g L of the
  whole chain.
- 19: deepest overlap at any of 60 samples per second of 3 s.

Settings. gsenv: solver, steps per second x substeps, tolerance; or a preset. MuJoCo: steps per second, integrator,
friction cone, dmin and dmax of solimp, solver and iterations where they are not Newton's 100, noslip iterations,
impratio, solref's time constant in timesteps (two, the least that it takes, where nothing is said). Where balls
bounce, which MuJoCo has no coefficient for, contacts are springs with the damping that gives it (solref in its
direct form) whose bounce takes contact_steps timesteps. PyBullet: steps per second, iterations, erp; "maximal" are
plain rigid bodies, the others Featherstone's."""
