"""Small problems solved by hand, each with its A and b, to 1e-9."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from gsenv.solver.problem.problem import ContactRows, Problem, Solution, solve

pytestmark = pytest.mark.nojit

EXACT = 1e-9
STACK = [[1, 0], [-1, 1]]  # box 1 on the ground, box 2 on box 1


def solved(problem: Problem, method: str = "pgs") -> Solution:
    solution = solve(problem, method, tolerance=1e-14)
    assert solution.converged
    return solution


def close(actual: NDArray[np.float64] | None, expected: object) -> None:
    assert actual is not None
    assert_allclose(actual, np.asarray(expected, float), atol=EXACT, rtol=0)


@pytest.mark.parametrize("method", ["pgs", "nncg", "apgd"])
def test_stack_of_two(method: str) -> None:
    # m = 1, dt = 1, g = 10: after gravity both move at -10
    problem = Problem.from_rows(1, STACK, velocity=[-10, -10], lower=0)
    close(problem.delassus.toarray(), [[1, -1], [-1, 2]])
    close(problem.rhs, [-10, 0])
    solution = solved(problem, method)
    close(solution.impulse, [20, 10])
    close(solution.body_velocity, [0, 0])
    close(solution.row_velocity, [0, 0])


def test_stack_with_a_heavy_top() -> None:
    problem = Problem.from_rows([1, 0.5], STACK, velocity=[-10, -10], lower=0)
    close(problem.delassus.toarray(), [[1, -1], [-1, 1.5]])
    close(problem.rhs, [-10, 0])
    solution = solved(problem)
    close(solution.impulse, [30, 20])
    close(solution.body_velocity, [0, 0])


def test_stack_assembled_by_hand() -> None:
    problem = Problem.from_delassus([[1, -1], [-1, 2]], [-10, 0], lower=0)
    solution = solved(problem)
    close(solution.impulse, [20, 10])
    assert solution.body_velocity is None


def test_separating_boxes_get_no_impulse() -> None:
    solution = solved(Problem.from_rows(1, STACK, velocity=[1, 5], lower=0))
    close(solution.impulse, [0, 0])
    close(solution.body_velocity, [1, 5])
    assert solution.sweeps == 0


# One row between two unit masses: J = [-1, 1], A = 2, w = v2 - v1 + bias.
RELATIVE = [[-1, 1]]


@pytest.mark.parametrize("velocity", [[3, -1], [-1, 3]])
def test_lock_pulls_as_well_as_pushes(velocity: list[float]) -> None:
    # momentum is shared: both end at the mean speed; lambda = -(v2 - v1) / 2, either sign
    problem = Problem.from_rows(1, RELATIVE, velocity)
    close(problem.delassus.toarray(), [[2]])
    close(problem.rhs, [velocity[1] - velocity[0]])
    solution = solved(problem)
    close(solution.impulse, [-(velocity[1] - velocity[0]) / 2])
    close(solution.body_velocity, [1, 1])


@pytest.mark.parametrize(
    ("velocity", "impulse", "after"),
    [
        # v2 - v1 = 5 > 2: lambda = -(5 - 2) / 2, each mass gives 1.5
        ([0, 5], -1.5, [1.5, 3.5]),
        ([0, 1], 0.0, [0, 1]),
        ([5, 0], 0.0, [5, 0]),
    ],
)
def test_relative_speed_limit(velocity: list[float], impulse: float, after: list[float]) -> None:
    # v2 - v1 <= 2: the row may only pull (upper = 0), from the speed w = v2 - v1 - 2 >= 0 on
    problem = Problem.from_rows(1, RELATIVE, velocity, bias=-2, upper=0)
    close(problem.delassus.toarray(), [[2]])
    close(problem.rhs, [velocity[1] - velocity[0] - 2])
    solution = solved(problem)
    close(solution.impulse, [impulse])
    close(solution.body_velocity, after)


@pytest.mark.parametrize(
    ("velocity", "impulse", "after"),
    [
        ([4, 0], 2.0, [2, 2]),  # the driver is faster: locked, lambda = -(0 - 4) / 2
        ([0, 4], 0.0, [0, 4]),  # the driven shaft overtakes: free
    ],
)
def test_one_way_clutch(velocity: list[float], impulse: float, after: list[float]) -> None:
    # v2 - v1 >= 0: the row may only push (lower = 0)
    problem = Problem.from_rows(1, RELATIVE, velocity, lower=0)
    close(problem.rhs, [velocity[1] - velocity[0]])
    solution = solved(problem)
    close(solution.impulse, [impulse])
    close(solution.body_velocity, after)


@pytest.mark.parametrize(("strength", "impulse"), [(10.0, 1.5), (1.0, 1.0)])
def test_motor_reaches_its_speed_or_its_bound(strength: float, impulse: float) -> None:
    # v2 - v1 = 3 wanted from rest: lambda = 3 / 2, unless the motor is too weak
    problem = Problem.from_rows(1, RELATIVE, [0, 0], bias=-3, lower=-strength, upper=strength)
    solution = solved(problem)
    close(solution.impulse, [impulse])
    close(solution.body_velocity, [-impulse, impulse])


def test_spring_by_softness() -> None:
    # k = 100, c = 2, dt = .1, C = .05, a unit mass at rest. Implicit Euler: the force at the
    # END of the step, lambda = -dt (k (C + dt v) + c v), so v = lambda solves
    # v (1 + dt^2 k + dt c) = -dt k C
    k, c, dt, error = 100.0, 2.0, 0.1, 0.05
    soft = 1 / (dt * (dt * k + c))
    bias = error * k / (dt * k + c)
    problem = Problem.from_rows(1, [[1]], [0], bias=bias, softness=soft)
    solution = solved(problem)
    expected = -dt * k * error / (1 + dt * dt * k + dt * c)
    close(solution.impulse, [expected])
    close(solution.body_velocity, [expected])
    close(solution.row_velocity + soft * solution.impulse, [0])


# Ball joint between A at r_A = (.5, 0, 0) and B at r_B = (-.5, 0, 0); coordinates
# (v_A, w_A, v_B, w_B). The error is A's anchor minus B's; its rate is
# v_A + w_A x r_A - v_B - w_B x r_B, with w x r = -[r] w.
R_A, R_B = np.array([0.5, 0, 0]), np.array([-0.5, 0, 0])
SPIN = np.array([0, 0, 0, 0, 0, 2.0, 0, 0, 0, 0, 0, 0])  # w_A = (0, 0, 2)
ERROR = np.array([0, 0.1, 0])
BETA = 0.2


def cross_matrix(r: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


BALL = np.hstack([np.eye(3), -cross_matrix(R_A), -np.eye(3), cross_matrix(R_B)])


def test_ball_joint() -> None:
    problem = Problem.from_rows(1, BALL, SPIN, bias=BETA * ERROR)
    close(problem.delassus.toarray(), np.diag([2, 2.5, 2.5]))
    close(problem.rhs, [0, 1.02, 0])  # A's anchor moves at w x r = (0, 1, 0), and beta C / dt
    solution = solved(problem)
    close(solution.impulse, [0, -0.408, 0])
    assert solution.body_velocity is not None
    change = [0, -0.408, 0, 0, 0, -0.204, 0, 0.408, 0, 0, 0, -0.204]
    close(solution.body_velocity - SPIN, change)
    # the rate of the error after the solve is -beta C: a fifth of it goes in one step
    close(BALL @ solution.body_velocity, [0, -0.02, 0])


def test_ball_joint_to_a_pinned_body() -> None:
    # B gives nothing: A = diag(1, 1.25, 1.25), lambda_y = -1.02 / 1.25 = -.816,
    # dv_A = lambda, dw_A = r_A x lambda = (0, 0, .5 * -.816)
    pinned = [1.0] * 6 + [0.0] * 6
    problem = Problem.from_rows(pinned, BALL, SPIN, bias=BETA * ERROR)
    close(problem.delassus.toarray(), np.diag([1, 1.25, 1.25]))
    close(problem.rhs, [0, 1.02, 0])
    solution = solved(problem)
    close(solution.impulse, [0, -0.816, 0])
    assert solution.body_velocity is not None
    close(solution.body_velocity - SPIN, [0, -0.816, 0, 0, 0, -0.408, 0, 0, 0, 0, 0, 0])
    close(BALL @ solution.body_velocity, [0, -0.02, 0])


@pytest.mark.parametrize(("axis", "impulse"), [(0, 0.0), (1, -0.408), (2, 0.0)])
def test_one_axis_of_the_ball_joint(axis: int, impulse: float) -> None:
    # A is diagonal, so each axis alone takes the same impulse as within the joint
    row = BALL[axis : axis + 1]
    problem = Problem.from_rows(1, row, SPIN, bias=BETA * ERROR[axis])
    close(problem.delassus.toarray(), [[(2, 2.5, 2.5)[axis]]])
    close(problem.rhs, [(0, 1.02, 0)[axis]])
    close(solved(problem).impulse, [impulse])


def test_weld() -> None:
    # Three more rows w_A - w_B. They meet the point rows in J_p M^-1 J_w^T = -[r_A] - [r_B] = 0,
    # so A = diag(2, 2.5, 2.5, 2, 2, 2) and the angular impulse is -(0, 0, 2) / 2.
    zero, one = np.zeros((3, 3)), np.eye(3)
    angular = np.hstack([zero, one, zero, -one])
    jacobian = np.vstack([BALL, angular])
    bias = [0, BETA * 0.1, 0, 0, 0, 0]
    problem = Problem.from_rows(1, jacobian, SPIN, bias=bias)
    close(problem.delassus.toarray(), np.diag([2, 2.5, 2.5, 2, 2, 2]))
    close(problem.rhs, [0, 1.02, 0, 0, 0, 2])
    solution = solved(problem)
    close(solution.impulse, [0, -0.408, 0, 0, 0, -1])
    # B's spin takes what A's loses; the point impulse turns both by -.204
    after = [0, -0.408, 0, 0, 0, 0.796, 0, 0.408, 0, 0, 0, 0.796]
    close(solution.body_velocity, after)


def test_spatial_inertia_as_a_matrix() -> None:
    # the same joint with M^-1 given as a dense and as a block-diagonal matrix
    solution = solved(Problem.from_rows(np.eye(12), BALL, SPIN, bias=BETA * ERROR))
    close(solution.impulse, [0, -0.408, 0])
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    inertia = tilt @ np.diag([1.0, 2.0, 4.0]) @ tilt.T
    inverse = np.eye(12)
    inverse[3:6, 3:6] = inertia
    problem = Problem.from_rows(inverse, BALL, SPIN, bias=BETA * ERROR)
    close(problem.delassus.toarray(), BALL @ inverse @ BALL.T)
    expected = -np.linalg.solve(problem.delassus.toarray(), problem.rhs)
    close(solved(problem).impulse, expected)


def test_box_sticks_and_slides_on_the_ground() -> None:
    # a unit mass, g dt = 10, mu = .5, pushed along a tangent that is no axis: the cone is round
    direction = np.array([0.6, 0.8])
    slow = Problem.from_rows(1, np.eye(3), [-10, *(4 * direction)], contacts=ContactRows(0.5))
    close(solved(slow).impulse, [10, *(-4 * direction)])
    fast = Problem.from_rows(1, np.eye(3), [-10, *(7 * direction)], contacts=ContactRows(0.5))
    solution = solved(fast)
    close(solution.impulse, [10, *(-5 * direction)])
    close(solution.body_velocity, [0, *(2 * direction)])
