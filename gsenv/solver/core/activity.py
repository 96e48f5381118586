"""Activities of islands."""

ALL_ASLEEP = 0
AWAKE = 1
DRIVEN = 2  # by a target joint, an actuator or an update function: awake, and may not fall asleep
KINEMATIC_CONTACT = 3  # touched by a moving kinematic body, whose rows may contradict others
