"""Vectors, things and commands of the naive Keepaway; vectors are complex numbers (x + iy), angles
degrees."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field

REACH = 0.3 + 0.085 + 0.7
TOUCH = 0.3 + 0.085
UNKNOWN = 10**9


def wrap(angle: float) -> float:
    while angle > 180:
        angle -= 360
    while angle <= -180:
        angle += 360
    return angle


def angle_of(v: complex) -> float:
    return math.degrees(cmath.phase(v)) if v else 0.0


def unit(angle: float) -> complex:
    return complex(math.cos(math.radians(angle)), math.sin(math.radians(angle)))


def size(v: complex) -> float:
    return math.sqrt(v.real * v.real + v.imag * v.imag)


def cut(value: float) -> int:
    """Cut the fraction off a number that may be an integer but for rounding."""
    return int(value + math.copysign(1e-9, value))


def clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def roll(decay: float, n: int) -> float:
    return sum(decay**k for k in range(n))


def nearest_multiple(value: float, step: float) -> float:
    return math.floor(value / step + 0.5) * step


def dot(a: complex, b: complex) -> float:
    return a.real * b.real + a.imag * b.imag


def cross(a: complex, b: complex) -> float:
    return a.real * b.imag - a.imag * b.real


@dataclass
class Thing:
    """A ball or player, or what somebody believes of one."""

    at: complex = 0j
    v: complex = 0j
    body: float = 0.0
    neck: float = 0.0
    age: int = UNKNOWN

    def copy(self) -> Thing:
        return Thing(self.at, self.v, self.body, self.neck, self.age)

    def later(self, n: int) -> complex:
        """Where a ball has rolled after n cycles."""
        return self.at + roll(0.94, n) * self.v


@dataclass
class Command:
    kind: str = ""
    value: float = 0.0
    angle: float = 0.0
    neck: float = 0.0


@dataclass
class Mind:
    """What one player believes and intends."""

    ball: Thing = field(default_factory=Thing)
    players: list[Thing] = field(default_factory=list)
    known: list[bool] = field(default_factory=list)
    meet: complex = 0j
    meet_cycle: int = -2
    option: str = ""
    target: int = -1
    start: int = -1
    action: int = -1
    action_cycle: int = -1
    runner: int = -1
    decides: bool = False
    order: list[int] = field(default_factory=list)
    variables: list[float] = field(default_factory=list)


def dash(power: float) -> Command:
    return Command("dash", cut(clip(power, -100, 100)))


def turn(me: Thing, angle: float) -> Command:
    return Command("turn", 0, cut(clip(wrap(angle) * (1 + 5 * size(me.v)), -180, 180)))


def kick(me: Thing, power: float, direction: float) -> Command:
    return Command("kick", cut(clip(power, 0, 100)), cut(wrap(direction - me.body)))


def rate(me: Thing, ball: Thing) -> float:
    gap = ball.at - me.at
    off = abs(wrap(angle_of(gap) - me.body))
    return 0.027 * (1 - 0.25 * off / 180 - 0.25 * (size(gap) - TOUCH) / 0.7)


def nearest(at: complex, things: list[Thing], known: list[bool], team: range) -> tuple[int, float]:
    ranked = sorted((size(things[j].at - at), j) for j in team if known[j])
    return (ranked[0][1], ranked[0][0]) if ranked else (-1, math.inf)


def turn_towards(me: Thing, point: complex) -> Command:
    return turn(me, angle_of(point - me.at - me.v) - me.body)
