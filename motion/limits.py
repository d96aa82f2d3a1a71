"""Speed and turn rate of a truck to the speeds of its wheels, within the limits of each wheel."""

from omnimate.motion.records import Settings, State
from omnimate.vehicle.compiled import compiled


@compiled
def stopped(truck: int, state: State) -> bool:
    """Return whether both wheels of a truck were commanded to stand in the step before."""
    return bool(state.speeds[2 * truck] == 0.0 and state.speeds[2 * truck + 1] == 0.0)


@compiled
def drive_truck(truck: int, speed: float, turn: float, state: State, settings: Settings) -> None:
    """Bring both wheels of a truck as near to a speed [m/s] and turn rate [rad/s] as the limits allow.

    Too fast a pair of wheels is slowed down in proportion, so that the path keeps its curvature; too
    large a step is shortened in proportion.
    """
    left, right = 2 * truck, 2 * truck + 1
    rim = 0.5 * settings.wheelbase[truck] * turn
    fastest = max(abs(speed - rim), abs(speed + rim), settings.speed)
    scale = settings.speed / fastest
    step_left = (speed - rim) * scale - state.speeds[left]
    step_right = (speed + rim) * scale - state.speeds[right]
    largest = settings.acceleration * settings.period
    share = largest / max(abs(step_left), abs(step_right), largest)
    if share == 1.0:  # exactly, so that a wheel that is to stand does stand
        state.speeds[left] = (speed - rim) * scale
        state.speeds[right] = (speed + rim) * scale
        return
    state.speeds[left] += share * step_left
    state.speeds[right] += share * step_right
