"""Links in 2D: poses and velocities, forces and inertias, coordinates of their joints."""

from __future__ import annotations

from .forces import add_inertia as add_inertia
from .forces import add_reaction as add_reaction
from .forces import added as added
from .forces import carried as carried
from .forces import carry as carry
from .forces import force_on as force_on
from .forces import impulse_at_origin as impulse_at_origin
from .forces import keep_momentum as keep_momentum
from .forces import moved as moved
from .forces import no_impulse as no_impulse
from .forces import reduced as reduced
from .forces import response_of as response_of
from .forces import set_applied as set_applied
from .forces import set_force as set_force
from .forces import set_inertia as set_inertia
from .forces import set_moment as set_moment
from .forces import set_motions as set_motions
from .forces import set_response as set_response
from .places import enter_joint as enter_joint
from .places import enter_link as enter_link
from .places import keep_axes as keep_axes
from .places import leave_link as leave_link
from .places import mismatch as mismatch
from .places import most_inverse as most_inverse
from .places import place_link as place_link
from .places import set_joint_motion as set_joint_motion
from .places import squared_turning as squared_turning
from .places import start_joint_rates as start_joint_rates
from .servos import add_ball_spring as add_ball_spring
from .servos import coordinate_of as coordinate_of
from .servos import is_isotropic as is_isotropic
from .servos import numbers_of as numbers_of
from .servos import set_pivot_direction as set_pivot_direction
from .servos import set_servo_direction as set_servo_direction
