"""The two-truck robot as a MuJoCo model: its dimensions, and the bodies that touch the floor.

A wheel's tread is a sphere of the wheel's radius, so that it meets the floor in one point below its centre;
each wheel and castor has a plane that `drive.Floor` keeps tangent to the rough floor below it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from studies.mismatch.engines.vocabulary import WHEELS

FEET = (*WHEELS, "a.castor", "b.castor")


@dataclass(frozen=True, slots=True)
class Tyre:
    radius: float  # radius of the tread [m]
    eccentricity: float = 0.0  # distance of the tread's centre from the axle [m]
    phase: float = 0.0  # phase of the eccentricity at wheel angle 0 [rad]
    softness: float = 0.006  # time constant of the contact [s]
    creep: float | None = None  # time constant of the friction [s]; None for as stiff as the time step allows
    impedance: float = 0.95  # impedance of the contact in MuJoCo's sense; a lower one yields to forces


@dataclass(frozen=True, slots=True)
class Truck:
    track: float  # distance between the wheels' contact points [m]
    mass: float  # mass without wheels and payload [kg]
    castor: float  # place of the castor ahead of the axle [m]
    toe: float = 0.0  # angle by which the axle is turned in the truck [rad]
    trail: float = 0.0  # trail of the castor [m]; 0 for a ball
    payload: float = 0.0  # mass of a payload that can move sideways [kg]


@dataclass(frozen=True, slots=True)
class Cable:
    """A round cable on the floor that one wheel meets."""

    wheel: str  # wheel that meets it
    x: float  # place of its middle [m]
    y: float  # place of its middle [m]
    direction: float  # direction in which it lies [rad]
    height: float  # diameter of the cable [m]
    length: float = 0.12  # length of the cable [m]


@dataclass(frozen=True, slots=True)
class Robot:
    """Everything that the physics is built from."""

    tyres: dict[str, Tyre]  # the driven wheels, by channel
    trucks: dict[str, Truck]  # the trucks, by name
    link: float  # length of the linkage at rest [m]
    spring: float  # stiffness of the slider [N/m]
    damper: float  # damping of the slider [N s/m]
    timestep: float = 0.0015  # step of the integration [s]
    cables: tuple[Cable, ...] = field(default=())  # cables on the floor
    tilt: tuple[float, float] = (0.0, 0.0)  # slopes of the floor along x and y
    impratio: float = 10.0  # stiffness of friction over that of the normal force


def random_robot(rng: np.random.Generator) -> Robot:
    """Return a healthy robot of the size of CLAPPER and OmniMate, with tyres that differ slightly."""
    radius, track = rng.uniform(0.065, 0.085), rng.uniform(0.30, 0.42)
    tyres = {name: Tyre(radius * (1 + rng.normal(0, 5e-4))) for name in WHEELS}
    trucks = {
        name: Truck(track * (1 + rng.normal(0, 2e-3)), rng.uniform(18, 30), castor * rng.uniform(0.16, 0.22))
        for name, castor in (("a", 1.0), ("b", -1.0))
    }
    return Robot(tyres, trucks, rng.uniform(0.85, 1.15), rng.uniform(10, 40), rng.uniform(10, 30))


# The part of a step's slip that friction takes back at the next one. At 1 the heading lags by half a step in
# bends, at 2 it does not but rings. Sliding castors must not have it: a drag that rings changes how far the
# wheels roll.
HOLD = 1.7
GRIP, CASTOR_GRIP, CASTOR_RADIUS = 1.0, 0.02, 0.03


def model_xml(robot: Robot) -> str:
    """Return the MJCF of a robot on its floor."""
    planes = "\n".join(
        f'<body name="floor {foot}" mocap="true"><geom name="floor {foot}" type="plane" size="9 9 1"/></body>'
        for foot in FEET
    )
    cables = "\n".join(_cable_xml(number, cable) for number, cable in enumerate(robot.cables))
    contacts = "\n".join(
        [_pair_xml(robot, foot, f"floor {foot}") for foot in FEET]
        + [_pair_xml(robot, cable.wheel, f"cable {number}") for number, cable in enumerate(robot.cables)]
    )
    servos = "\n".join(
        f'<velocity name="{wheel}" joint="{wheel}" kv="40" forcerange="-15 15"/>' for wheel in WHEELS
    )
    loads = "\n".join(
        f'<position name="{name}.load" joint="{name}.load" kp="400" kv="150"/>'
        for name, truck in robot.trucks.items()
        if truck.payload
    )
    gx, gy = (9.81 * tilt for tilt in robot.tilt)
    radius = sum(tyre.radius for tyre in robot.tyres.values()) / 4
    return f"""
<mujoco model="two trucks">
  <compiler angle="radian" inertiafromgeom="auto"/>
  <option timestep="{robot.timestep}" integrator="Euler" cone="elliptic" impratio="{robot.impratio}"
          gravity="{gx} {gy} -9.81"/>
  <default><geom contype="0" conaffinity="0" condim="3"/></default>
  <worldbody>
    {planes}
    {cables}
    <body name="a" pos="0 0 {radius}"><freejoint/>
      {_truck_xml("a", robot, radius)}
      <body name="link" pos="0 0 0">
        <inertial pos="-0.3 0 0" mass="0.5" diaginertia="0.001 0.01 0.01"/>
        <joint name="joint_a" axis="0 0 1" damping="0.02"/><joint name="pitch_a" axis="0 1 0" damping="0.02"/>
        <body name="slider" pos="{-robot.link} 0 0">
          <inertial pos="0.3 0 0" mass="0.5" diaginertia="0.001 0.01 0.01"/>
          <joint name="link" type="slide" axis="-1 0 0" stiffness="{robot.spring}" damping="{robot.damper}"/>
          <body name="b">
            <joint name="pitch_b" axis="0 1 0" damping="0.02"/>
            <joint name="roll_b" axis="1 0 0" damping="0.02"/>
            <joint name="joint_b" axis="0 0 1" damping="0.02"/>
            {_truck_xml("b", robot, radius)}
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact>{contacts}</contact>
  <actuator>{servos}{loads}</actuator>
</mujoco>"""


def _truck_xml(name: str, robot: Robot, height: float) -> str:
    truck = robot.trucks[name]
    deck = f'<geom type="box" size="0.25 0.18 0.08" pos="{truck.castor * 0.15} 0 0.05" mass="{truck.mass}"/>'
    wheels = "\n".join(
        _wheel_xml(f"{name}.{side}", robot.tyres[f"{name}.{side}"], truck.track / 2 * sign)
        for side, sign in (("left", 1.0), ("right", -1.0))
    )
    axle = f'<body name="{name} axle" euler="0 0 {truck.toe}">{wheels}</body>'
    load = (
        f'<body pos="0 0 0.15"><joint name="{name}.load" type="slide" axis="0 1 0" damping="20"/>'
        f'<geom type="box" size="0.05 0.05 0.05" mass="{truck.payload}"/></body>'
        if truck.payload
        else ""
    )
    return f"{deck}{axle}{_castor_xml(name, truck, height)}{load}"


def _wheel_xml(name: str, tyre: Tyre, y: float) -> str:
    """Return a wheel whose tread's centre stands off its axle: below it when the wheel's angle is -phase."""
    x, z = -tyre.eccentricity * math.sin(tyre.phase), -tyre.eccentricity * math.cos(tyre.phase)
    return (
        f'<body name="{name}" pos="0 {y} 0"><joint name="{name}" axis="0 1 0" armature="0.1"/>'
        f'<inertial pos="0 0 0" mass="1" diaginertia="0.002 0.004 0.002"/>'
        f'<geom name="{name}" type="sphere" size="{tyre.radius}" pos="{x} 0 {z}"/></body>'
    )


def _castor_xml(name: str, truck: Truck, height: float) -> str:
    """Return a ball castor, or where there is trail a wheel that swivels behind its pin, with friction."""
    z = CASTOR_RADIUS - height
    if not truck.trail:
        return (
            f'<geom name="{name}.castor" type="sphere" size="{CASTOR_RADIUS}"'
            f' pos="{truck.castor} 0 {z}" mass="0.1"/>'
        )
    return (
        f'<body pos="{truck.castor} 0 {z}">'
        f'<joint name="{name}.swivel" axis="0 0 1" damping="0.02" frictionloss="0.5"/>'
        f'<inertial pos="0 0 0" mass="0.2" diaginertia="0.001 0.001 0.001"/>'
        f'<body pos="{-truck.trail} 0 0"><joint axis="0 1 0" damping="0.0005"/>'
        f'<geom name="{name}.castor" type="sphere" size="{CASTOR_RADIUS}" mass="0.3"/></body></body>'
    )


def _cable_xml(number: int, cable: Cable) -> str:
    radius, half = cable.height / 2, cable.length / 2
    dx, dy = half * math.cos(cable.direction), half * math.sin(cable.direction)
    ends = f"{cable.x - dx} {cable.y - dy} {radius} {cable.x + dx} {cable.y + dy} {radius}"
    return f'<geom name="cable {number}" type="capsule" size="{radius}" fromto="{ends}"/>'


def _pair_xml(robot: Robot, foot: str, ground: str) -> str:
    tyre = robot.tyres.get(foot)
    rolling = tyre is not None or robot.trucks[foot[0]].trail > 0
    grip = GRIP if rolling else CASTOR_GRIP
    softness, impedance = (tyre.softness, tyre.impedance) if tyre else (0.006, 0.95)
    hold = ""
    if tyre:
        hold = f'solreffriction="-1 {-HOLD / robot.timestep if tyre.creep is None else -1 / tyre.creep}"'
    return (
        f'<pair geom1="{foot}" geom2="{ground}" condim="3" friction="{grip} {grip} 0.001 0.0001 0.0001"'
        f' solref="{softness} 1" solimp="{impedance} {impedance + 0.04} 0.001" {hold}/>'
    )
