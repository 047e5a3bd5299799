"""Keepaway written for reading: one object per player, no compiled code, no short cuts.

Follows the draws of `core.keepaway` and must agree with it to rounding, cycle by cycle. Vectors are complex
numbers (x + iy), angles are degrees.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, field

from core.keepaway.match import Streams
from core.keepaway.pitch import KeepawayConfig

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


# Kicking.


def freeze(me: Thing, ball: Thing) -> Command:
    power = min(size(ball.v) / rate(me, ball), 100)
    left = 1 - power * rate(me, ball) / size(ball.v)
    if size(ball.at + left * ball.v - me.at - me.v) < 0.8 * REACH:
        return kick(me, power, angle_of(-ball.v))
    gap = ball.at - me.at - me.v
    wish = me.at + me.v + gap * min(0.7 * REACH, size(gap) - 0.1) / size(gap)
    push = wish - ball.at - ball.v
    return kick(me, size(push) / rate(me, ball), angle_of(push))


def kick_close(me: Thing, ball: Thing, relative: float, ratio: float) -> Command:
    push = me.at + me.v + (TOUCH + ratio * 0.7) * unit(me.body + relative) - ball.at - ball.v
    power = size(push) / rate(me, ball)
    if power > 100 and size(ball.v) > 0.1:
        return freeze(me, ball)
    return kick(me, power, angle_of(push))


def hold(me: Thing, ball: Thing, mind: Mind, rivals: range, ratio: float, facing: float) -> Command:
    relative = 0.0
    rival, distance = nearest(ball.at, mind.players, mind.known, rivals)
    if distance < 5:
        away = angle_of(me.at - mind.players[rival].at)
        side = -45 if wrap(mind.players[rival].body - away) >= 0 else 45
        relative = wrap(away + side - me.body)
    in_place = size(ball.at - me.at - ratio * unit(facing + relative)) < 0.3
    if in_place and size(ball.at + ball.v - me.at - me.v) < 0.85 * REACH:
        return turn_towards(me, 52.5 if facing == 0 else -52.5)
    return kick_close(me, ball, relative, ratio)


def pass_to(me: Thing, ball: Thing, target: complex, rival_distance: float) -> Command:
    way = target - ball.at
    direction = angle_of(way)
    grow = 1 / 0.94
    n = round(math.log(1 + size(way) * (grow - 1) / 1.2) / math.log(grow))
    speed = 1.2 * grow ** float(n)
    if size(me.at + me.v - ball.at - speed * unit(direction)) < TOUCH:
        beside = abs(dot(unit(direction), me.at - ball.at))
        speed = beside - TOUCH if speed < beside else beside + TOUCH
    strongest = 100 * rate(me, ball)
    side = cross(unit(direction), ball.v)
    if strongest <= abs(side):
        capped = direction - (90 if side > 0 else -90)
    else:
        capped = direction - math.degrees(math.asin(side / strongest))
    if speed > 3:
        if size(ball.v + strongest * unit(capped)) > 0.85 * 2.7:
            return kick(me, 100, capped)
        if rate(me, ball) > 0.85 * 0.027:
            return freeze(me, ball)
        return kick_close(me, ball, 0, 0.16)
    push = speed * unit(direction) - ball.v
    power = size(push) / rate(me, ball)
    if power <= 105 or (power <= 130 and rival_distance < 2):
        return kick(me, power, capped if power > 100 else angle_of(push))
    return kick_close(me, ball, 0, 0.16)


# Moving.


def power_for(forward: float, axial: float, cycles: int) -> float:
    speed = clip(forward / roll(0.4, max(cycles, 1)), -1.05, 1.05)
    return clip((speed - axial) / 0.006, -100, 100)


def policy_turns(me: Thing, target: complex, cycles: int) -> bool:
    way = target - me.at - roll(0.4, min(cycles, 4)) * me.v
    distance = size(target - me.at)
    slack = 3 * REACH if distance > 20 else 2 * REACH if distance > 10 else 0.9 * REACH
    behind = dot(unit(me.body), way) < 0 and distance > 2.5
    return abs(cross(unit(me.body), way)) > slack or behind


def policy_angle(me: Thing, target: complex, cycles: int) -> float:
    return angle_of(target - me.at - roll(0.4, min(cycles, 4)) * me.v) - me.body


def policy_power(me: Thing, target: complex, cycles: int) -> float:
    axis = unit(me.body)
    return power_for(dot(axis, target - me.at), dot(axis, me.v), cycles)


def policy_command(me: Thing, target: complex, cycles: int) -> Command:
    if policy_turns(me, target, cycles):
        return turn(me, policy_angle(me, target, cycles))
    return dash(policy_power(me, target, cycles))


def distance_after(me: Thing, target: complex, cycles: int) -> float:
    """Distance from the target after `cycles` cycles of the move policy, played out without noise."""
    me = me.copy()
    for left in range(cycles, 0, -1):
        if policy_turns(me, target, left):
            inertia = 1 + 5 * size(me.v)
            me.body = wrap(
                me.body + clip(wrap(policy_angle(me, target, left)) * inertia, -180, 180) / inertia
            )
        else:
            me.v += 0.006 * policy_power(me, target, left) * unit(me.body)
            if size(me.v) > 1.05:
                me.v *= 1.05 / size(me.v)
        me.at += me.v
        me.v *= 0.4
    return size(target - me.at)


def meeting(me: Thing, ball: Thing, mind: Mind, now: int) -> int:
    good = (n for n in range(31) if distance_after(me, ball.later(n), n) < REACH)
    first = next(good, -1)
    if first < 0:
        return first
    if mind.meet_cycle != now - 1:
        return first
    for n in range(first, min(first + 2, 30) + 1):
        if size(ball.v) * 0.94**n <= 0.6:
            return first
        sure = distance_after(me, ball.later(n), n) < 0.7 * REACH
        if size(ball.later(n) - mind.meet) < 1 and sure:
            return n
    return first


def step_meant(me: Thing, command: Command) -> complex:
    """How far a command takes a player whom nothing stops, without noise."""
    if command.kind != "dash":
        return me.v
    step = me.v + 0.006 * command.value * unit(me.body)
    return step * min(1, 1.05 / size(step)) if step else step


def gap_after_dash(me: Thing, ball: Thing, power: float) -> float:
    return size(ball.at + ball.v - me.at - me.v - 0.006 * power * unit(me.body))


def one_dash(me: Thing, ball: Thing, facing: float) -> Command | None:
    axis, gap = unit(me.body), ball.at + ball.v - me.at
    forward, offset, radius = dot(axis, gap), abs(cross(axis, gap)), TOUCH + 0.7 / 6
    if offset < radius:
        half = math.sqrt(radius * radius - offset * offset)
        forward += half if dot(axis, unit(facing)) > 0 else -half
    power = power_for(forward, dot(axis, me.v), 1)
    return None if gap_after_dash(me, ball, power) >= 0.95 * REACH else dash(power)


def run_into(me: Thing, ball: Thing) -> Command | None:
    axis = unit(me.body)
    power = power_for(dot(axis, ball.at + ball.v - me.at), dot(axis, me.v), 1)
    near = size(ball.at - me.at) <= size(ball.v) + 1.05
    return dash(power) if near and gap_after_dash(me, ball, power) < TOUCH else None


def stop_for(me: Thing, ball: Thing) -> Command | None:
    waits = size(ball.later(2) - me.at) < 0.8 * REACH
    return dash(power_for(0, dot(unit(me.body), me.v), 1)) if waits else None


def close_intercept(me: Thing, ball: Thing, rival_distance: float, facing: float) -> Command | None:
    def gap(n: int) -> float:
        return size(ball.later(n) - me.at - roll(0.4, n) * me.v)

    face = turn(me, facing - me.body)
    if rival_distance <= 3:
        return one_dash(me, ball, facing) or (face if gap(2) < 0.8 * REACH else None)
    turned = abs(wrap(facing - me.body)) - 180 / (1 + 5 * size(me.v)) < 30
    if gap(2) < 0.8 * REACH or gap(1) < TOUCH or (gap(1) < 0.8 * REACH and turned):
        return face
    command = run_into(me, ball) or stop_for(me, ball)
    if command is None and gap(1) < 0.8 * REACH:
        command = face
    return command or one_dash(me, ball, facing)


def go_to_ball(me: Thing, ball: Thing, mind: Mind, now: int, rival_distance: float, facing: float) -> Command:
    n = meeting(me, ball, mind, now)
    if n < 0:
        n = 100
    mind.meet, mind.meet_cycle = ball.later(n), now
    if n < 3:
        command = close_intercept(me, ball, rival_distance, facing)
        if command is not None:
            return command
    if size(me.at + roll(0.4, min(n, 4)) * me.v - mind.meet) < 0.5:
        return turn(me, facing - me.body)
    return policy_command(me, mind.meet, n)


def cycles_needed(player: Thing, point: complex, limit: int) -> int:
    way = point - player.at
    distance = size(way)
    if distance < REACH:
        return 0
    speed, axial = size(player.v), dot(player.v, way) / distance
    off = abs(wrap(angle_of(way) - player.body))
    cycles = 0
    while off > 10 and cycles < 5:
        cycles += 1
        off -= 180 / (1 + 5 * speed)
        distance -= axial
        speed, axial = 0.4 * speed, 0.4 * axial
    while distance > REACH and cycles <= limit:
        cycles += 1
        axial = min(axial + 0.6, 1.05)
        distance -= axial
        axial *= 0.4
    return cycles


def fastest(ball: Thing, things: list[Thing], known: list[bool], team: range) -> tuple[int, int]:
    for n in range(31):
        ready = [
            (cycles_needed(things[i], ball.later(n), n), i)
            for i in team
            if known[i] and size(ball.later(n) - things[i].at) < (n + 1) * 1.05 + REACH
        ]
        if ready and min(ready)[0] <= n:
            return soonest(ready), n
    return -1, 31


def soonest(ready: list[tuple[int, int]]) -> int:
    """Who of (cycles, player) needs fewest cycles; of equals the last."""
    return min(ready, key=lambda one: (one[0], -one[1]))[1]


def keeper_to_go(ball: Thing, things: list[Thing], known: list[bool], keepers: range, takers: range) -> int:
    """Which keeper goes to the ball: soonest where anybody, keeper or taker, can first have it."""
    n = min(fastest(ball, things, known, keepers)[1], fastest(ball, things, known, takers)[1])
    if n > 30:
        return -1
    ready = [(cycles_needed(things[i], ball.later(n), 60), i) for i in keepers if known[i]]
    return soonest(ready) if ready else -1


def cycles_to_ball(player: Thing, ball: Thing) -> int:
    """Cycles to the first point of the ball's way that the player reaches before the ball."""
    for n in range(1, 31):
        if size(ball.later(n) - player.at) < n * 1.05 + REACH:
            cycles = cycles_needed(player, ball.later(n), n)
            if cycles < n:
                return cycles
    return 30


def cone(frm: complex, to: complex, things: list[Thing], known: list[bool], takers: range) -> list[complex]:
    """Return the positions, relative to `frm`, of takers in the cone of a pass."""
    way, inside = to - frm, []
    for j in takers:
        at = things[j].at - frm
        if known[j] and 0 < dot(at, way) < dot(way, way) and abs(cross(way, at)) < 0.3 * dot(at, way):
            inside.append(at)
    return inside


def move_to(me: Thing, point: complex) -> Command:
    off = wrap(angle_of(point - me.at - me.v / 0.6) - me.body)
    axis = unit(me.body)
    if abs(off) < 7:
        return dash(power_for(dot(axis, point - me.at), dot(axis, me.v), 1))
    turns, left, speed = 0, abs(off), size(me.v)
    while left > 7 and turns < 3:
        left -= 180 / (1 + 5 * speed)
        speed *= 0.4
        turns += 1
    return dash(power_for(0, dot(axis, me.v), 1)) if turns >= 3 else turn(me, off)


class NaiveMatch:
    """A match of `core.keepaway.match.Match`, cycle by cycle."""

    def __init__(self, config: KeepawayConfig, streams: Streams) -> None:
        self.config, self.streams = config, streams
        self.keepers = range(config.n_keepers)
        self.takers = range(config.n_keepers, config.n_players)
        self.everybody = range(config.n_players)
        bodies = streams.placement.uniform(-180, 180, config.n_players)
        self.players = [Thing(body=float(b)) for b in bodies]
        self.clock = 0
        self.phases = list(config.see_phases or [0] * config.n_players)
        self.ball = Thing()
        self.stuck_at, self.stuck_since = complex(math.inf, 0), 0
        self.start_episode()

    def start_episode(self) -> None:
        rng = self.streams.placement
        w, h = self.config.length_m / 2, self.config.width_m / 2
        rotation = int(3 * rng.random())
        for i, player in enumerate(self.players):
            u, v = 3 * rng.random(), 3 * rng.random()
            corners = (complex(u - w, v - h), complex(w - u, v - h), complex(w - u, h - v))
            if i in self.takers:
                player.at = complex(u - w, h - v)
            else:
                player.at = (
                    corners[(i + rotation) % 3] if i < 3 else complex(u * (2 / 3) - 1, v * (2 / 3) - 1)
                )
            player.v = 0j
        self.ball.at, self.ball.v = complex(4 - w, 4 - h), 0j
        if self.config.see_phases is None:
            self.draw_phases()
        self.cycle, self.takes, self.end = 0, 0, ""
        minds = []
        for i in self.everybody:
            old = self.minds[i] if hasattr(self, "minds") else Mind(players=[Thing() for _ in self.everybody])
            # Places believed before stay in memory, but nobody relies on them.
            fresh = Mind(ball=old.ball, players=old.players, known=[False for _ in self.everybody])
            fresh.ball.age = UNKNOWN
            for thing in fresh.players:
                thing.age = UNKNOWN
            minds.append(fresh)
        self.minds = minds
        self.commands = [Command() for _ in self.everybody]
        self.ball_hit, self.hit = False, [False for _ in self.everybody]

    def draw_phases(self) -> None:
        rng, phases = self.streams.placement, self.phases
        for i in self.everybody:
            joined_alone, phase = rng.random() >= 0.5, int(3 * rng.random())
            phases[i] = phase if joined_alone or i == 0 else phases[i - 1]

    def sees(self, i: int) -> bool:
        return (self.clock + self.phases[i]) % 3 != 2

    def rivals(self, i: int) -> range:
        return self.takers if i in self.keepers else self.keepers

    def facing(self, i: int) -> float:
        return 0.0 if i in self.keepers else 180.0

    # Perception.

    def perceive(self) -> None:
        if self.config.exact_state:
            for mind in self.minds:
                mind.ball, mind.players = self.ball, self.players
                mind.known = [True for _ in self.everybody]
                mind.ball.age = 0
            return
        if self.config.view_angle_deg < 360:
            for i in self.everybody:
                self.listen(i)
        for i in self.everybody:
            self.reckon(i)
        for i in filter(self.sees, self.everybody):
            myself = self.players[i].copy()
            myself.age = 0
            self.minds[i].players[i] = myself
        for i in self.everybody:
            for j in range(i + 1, self.config.n_players):
                self.look_at_player(i, j, self.players[i], self.players[j])
        for i in filter(self.sees, self.everybody):
            self.look_at_ball(i)
        for mind in self.minds:
            mind.known = [thing.age <= 12 for thing in mind.players]

    def reckon(self, i: int) -> None:
        mind, me, ball = self.minds[i], self.minds[i].players[i], self.minds[i].ball
        body, command = self.players[i], self.commands[i]
        if command.kind == "turn":
            me.body = wrap(me.body + command.angle / (1 + 5 * size(me.v)))
        me.at += step_meant(me, command) if self.hit[i] else body.v / 0.4
        me.v, me.neck = body.v, body.neck
        if me.age < UNKNOWN:
            me.age = 0
        if ball.age < UNKNOWN:
            ball.age += 1
            self.reckon_ball(i)
            if self.ball_hit and self.hit[i]:
                gap = ball.at - me.at
                ball.at = me.at + gap * 0.2 / max(size(gap), 1e-9)
                ball.v *= -0.1
            self.still_near_rival(i)
        runs = fastest(ball, mind.players, mind.known, self.rivals(i))[0] if ball.age < UNKNOWN else -1
        for j, other in enumerate(mind.players):
            if j == i or other.age == UNKNOWN:
                continue
            other.age += 1
            if j not in self.rivals(i):
                other.at += other.v
                other.v *= 0.4
            elif j == runs:
                gap = ball.at - other.at
                other.at += 0.3 * gap / size(gap) if gap else 0
            else:
                forward = 1 if i in self.keepers else -1
                speed = ball.v.real * forward
                step = (0.25 if speed > 0 else -0.25) * (2 if abs(speed) > 1 else 1)
                other.at += step * forward

    def reckon_ball(self, i: int) -> None:
        me, ball, command = self.minds[i].players[i], self.minds[i].ball, self.commands[i]
        if command.kind == "kick":
            then = Thing(me.at - me.v / 0.4, body=me.body)
            if size(ball.at - then.at) <= REACH:
                ball.v += min(rate(then, ball) * command.value, 2.7) * unit(me.body + command.angle)
                if size(ball.v) > 3:
                    ball.v *= 3 / size(ball.v)
        ball.at += ball.v
        ball.v *= 0.94

    def still_near_rival(self, i: int) -> None:
        mind = self.minds[i]
        if any(mind.known[j] and size(mind.ball.at - mind.players[j].at) < REACH for j in self.rivals(i)):
            mind.ball.v = 0j

    def report(self, a: Thing, b: Thing) -> tuple[float, float, float, float, float]:
        gap, rv = b.at - a.at, b.v - a.v
        distance = reported = size(gap)
        u = gap / distance if gap else 1 + 0j
        away, across = dot(rv, u), cross(u, rv)
        if self.config.quantise:
            near = max(distance, 1e-3)
            reported = nearest_multiple(math.exp(nearest_multiple(math.log(near), 0.1)), 0.1)
            away = reported * nearest_multiple(away / near, 0.02)
            across = reported * math.radians(nearest_multiple(math.degrees(across / near), 0.1))
        return distance, angle_of(gap), reported, away, across

    def note(self, i: int, direction: float, report: tuple[float, ...], moving: bool, belief: Thing) -> None:
        me = self.players[i]
        _, _, reported, away, across = report
        if self.config.quantise:
            gaze = me.body + me.neck
            direction = nearest_multiple(direction - gaze, 1.0) + gaze
        u = unit(direction)
        belief.at = me.at + reported * u
        if moving:
            belief.v = me.v + away * u + across * u * 1j
        belief.age = 0

    def in_view(self, i: int, direction: float) -> bool:
        me, angle = self.players[i], self.config.view_angle_deg
        return angle >= 360 or abs(wrap(direction - me.body - me.neck)) <= angle / 2

    def look_at_player(self, i: int, j: int, a: Thing, b: Thing) -> None:
        report = self.report(a, b)
        for me, other, direction in ((i, j, report[1]), (j, i, wrap(report[1] + 180))):
            if not self.sees(me):
                continue
            named = report[0] <= 20 or 20 * self.streams.perception.random() > report[0] - 20
            seen = named and self.in_view(me, direction)
            if seen or (report[0] < 3 and self.minds[me].known[other]):
                belief = self.minds[me].players[other]
                self.note(me, direction, report, seen, belief)
                if seen:
                    body = self.players[other].body
                    belief.body = wrap(nearest_multiple(body, 1.0)) if self.config.quantise else body

    def look_at_ball(self, i: int) -> None:
        mind, report = self.minds[i], self.report(self.players[i], self.ball)
        seen = self.in_view(i, report[1])
        if not seen and report[0] >= 3:
            return
        expected, age = mind.ball.v, mind.ball.age
        self.note(i, report[1], report, seen, mind.ball)
        slack, surprise = 0.1 * size(expected), mind.ball.v - expected
        if seen and age < UNKNOWN and abs(surprise.real) < slack and abs(surprise.imag) < slack:
            mind.ball.v = 0.5 * (mind.ball.v + expected)
        if report[2] > REACH:
            self.still_near_rival(i)

    def listen(self, i: int) -> None:
        team = self.keepers if i in self.keepers else self.takers
        others = [j for j in team if j != i]
        if not others:
            return
        speaker = others[int(len(others) * self.streams.perception.random())]
        mine, told = self.minds[i], self.minds[speaker]
        if told.players[speaker].age > 0:
            return
        if mine.players[speaker].age > 0:
            mine.players[speaker].at = told.players[speaker].at
            mine.players[speaker].age = 0
        near = size(told.ball.at - told.players[speaker].at) < 20
        contradicts = mine.ball.age > 0 and size(told.ball.v - mine.ball.v) > 0.3
        if told.ball.age == 0 and near and (mine.ball.age > 3 or contradicts):
            mine.ball = told.ball.copy()
            mine.ball.age = 1
        here = told.players[speaker].at
        seen = [(size(told.players[j].at - here), j) for j in self.rivals(i) if told.players[j].age == 0]
        if seen:
            rival = min(seen)[1]
            if mine.players[rival].age > 1:
                mine.players[rival].at = told.players[rival].at
                mine.players[rival].age = 1

    # Deciding.

    def begin(self) -> list[int]:
        """Perceive, put keepers into options, and return those that have to decide."""
        self.perceive()
        for i in self.keepers:
            mind, me = self.minds[i], self.minds[i].players[i]
            mind.decides = False
            if mind.ball.age > 10:
                self.enter(i, "SearchBall")
                continue
            mind.runner = keeper_to_go(mind.ball, mind.players, mind.known, self.keepers, self.takers)
            if size(mind.ball.at - me.at) < REACH:
                self.open_decision(i)
            else:
                self.enter(i, "GoToBall" if mind.runner == i else "GetOpen")
        return [i for i in self.keepers if self.minds[i].decides]

    def open_decision(self, i: int) -> None:
        mind = self.minds[i]
        at = [thing.at for thing in mind.players]
        aim = sorted(self.keepers, key=lambda j: dot(at[j] - at[i], at[j] - at[i]))[max(mind.action, 0)]
        if mind.action > 0 and mind.action_cycle == self.cycle - 1 and mind.known[aim]:
            mind.action_cycle, mind.target = self.cycle, aim
            self.enter(i, "PassBall", aim)
        elif not all(mind.known):
            self.enter(i, "HoldBall")
        else:
            mind.decides = True
            mind.order, mind.variables = self.observe(i)

    def observe(self, i: int) -> tuple[list[int], list[float]]:
        at = [thing.at for thing in self.minds[i].players]
        keepers = sorted(self.keepers, key=lambda j: dot(at[j] - at[i], at[j] - at[i]))
        takers = sorted(self.takers, key=lambda j: dot(at[j] - at[i], at[j] - at[i]))
        others = keepers[1:] + takers
        variables = [size(at[i])]
        variables += [size(at[j] - at[i]) for j in others]
        variables += [size(at[j]) for j in others]
        variables += [min(size(at[t] - at[k]) for t in takers) for k in keepers[1:]]
        for k in keepers[1:]:
            angles = [abs(wrap(angle_of(at[k] - at[i]) - angle_of(at[t] - at[i]))) for t in takers]
            variables.append(min(angles))
        return keepers + takers, variables

    def enter(self, i: int, option: str, target: int = -1, anew: bool = False) -> None:
        mind = self.minds[i]
        if anew or (mind.option, mind.target) != (option, target):
            mind.option, mind.target, mind.start = option, target, self.cycle

    def choose(self, policy: str, i: int) -> int:
        mind, k = self.minds[i], self.config.n_keepers
        if policy == "random":
            return int(k * self.streams.policy.random())
        if policy == "hold" or mind.variables[k] > 5:
            return 0
        distances, angles = mind.variables[-2 * (k - 1) : -(k - 1)], mind.variables[-(k - 1) :]
        scores = [90.0] + [4 * d + a for d, a in zip(distances, angles, strict=True)]
        return scores.index(max(scores))

    # Acting.

    def finish(self, actions: dict[int, int]) -> bool:
        for i, action in actions.items():
            mind = self.minds[i]
            self.enter(i, "PassBall" if action else "HoldBall", mind.order[action] if action else -1, True)
            mind.action, mind.action_cycle = action, self.cycle
        self.commands = [
            self.command_keeper(i) if i in self.keepers else self.command_taker(i) for i in self.everybody
        ]
        if self.config.view_angle_deg < 360:
            for i in self.everybody:
                self.turn_neck(i)
        self.move()
        self.collide()
        self.cycle += 1
        self.clock += 1
        self.judge()
        return bool(self.end)

    def command_keeper(self, i: int) -> Command:
        mind, me, ball = self.minds[i], self.minds[i].players[i], self.minds[i].ball
        if mind.option == "HoldBall":
            return hold(me, ball, mind, self.takers, 0.7, 0)
        if mind.option == "PassBall":
            rival = nearest(ball.at, mind.players, mind.known, self.takers)[1]
            return pass_to(me, ball, mind.players[mind.target].at, rival)
        if mind.option == "GoToBall":
            rival = nearest(me.at, mind.players, mind.known, self.takers)[1]
            return go_to_ball(me, ball, mind, self.cycle, rival, 0)
        if mind.option == "GetOpen":
            return self.get_open(i)
        return turn(me, 60)

    def get_open(self, i: int) -> Command:
        mind, me = self.minds[i], self.minds[i].players[i]
        arrival = 30 if mind.runner < 0 else cycles_to_ball(mind.players[mind.runner], mind.ball)
        frm = mind.ball.later(arrival)
        best, least = 0j, math.inf
        for column in range(5):
            for row in range(5):
                point = complex(
                    self.config.length_m / 2 * 0.7 * (column / 2 - 1),
                    self.config.width_m / 2 * 0.7 * (row / 2 - 1),
                )
                others = [j for j in self.everybody if j != i and mind.known[j]]
                crowd = sum(1 / max(size(mind.players[j].at - point), 1e-6) for j in others)
                blocked = any(
                    size(at) < size(point - frm)
                    for at in cone(frm, point, mind.players, mind.known, self.takers)
                )
                if crowd < least and not blocked:
                    best, least = point, crowd
        if size(me.at - best) < 1.5:
            return turn_towards(me, mind.ball.at)
        return move_to(me, best)

    def command_taker(self, i: int) -> Command:
        mind, me, ball = self.minds[i], self.minds[i].players[i], self.minds[i].ball
        if ball.age > 10:
            self.enter(i, "SearchBall")
            return turn(me, 60)
        mates = [j for j in self.takers if j != i and mind.known[j]]
        rank = sum((size(mind.players[j].at - ball.at), j) < (size(me.at - ball.at), i) for j in mates)
        if rank == 0 and size(ball.at - me.at) < REACH:
            self.enter(i, "HoldBall")
            return hold(me, ball, mind, self.keepers, 0.3, 180)
        mark = self.most_open(mind) if rank >= 2 else -1
        if mark >= 0:
            self.enter(i, "BlockPass", mark)
            return self.block(i, mark)
        first, distance = nearest(ball.at, mind.players, mind.known, self.everybody)
        if first in mates and distance < REACH:
            self.enter(i, "WatchBall")
            return turn_towards(me, ball.at + ball.v)
        self.enter(i, "GoToBall")
        rival = nearest(me.at, mind.players, mind.known, self.keepers)[1]
        return go_to_ball(me, ball, mind, self.cycle, rival, 180)

    def most_open(self, mind: Mind) -> int:
        holder = nearest(mind.ball.at, mind.players, mind.known, self.keepers)[0]
        open_keepers = [
            (len(cone(mind.ball.at, mind.players[k].at, mind.players, mind.known, self.takers)), k)
            for k in self.keepers
            if k != holder and mind.known[k]
        ]
        return min(open_keepers)[1] if open_keepers else -1

    def block(self, i: int, mark: int) -> Command:
        mind, me = self.minds[i], self.minds[i].players[i]
        at = mind.players[mark].at
        way = mind.ball.at - at
        point = at + way * 4 / max(size(way), 4)
        if size(me.at - point) < 2:
            return turn(me, 80 if self.cycle % 2 == 0 else -80)
        return move_to(me, point)

    def turn_neck(self, i: int) -> None:
        mind, me, command = self.minds[i], self.minds[i].players[i], self.commands[i]
        if mind.option in ("HoldBall", "PassBall"):
            return
        point = 0j if mind.option == "GetOpen" else mind.ball.later(1)
        wanted = wrap(angle_of(point - me.at - step_meant(me, command)) - me.body)
        if command.kind == "turn":
            wanted = wrap(wanted - command.angle / (1 + 5 * size(me.v)))
        if mind.option == "SearchBall":
            wanted = 0.0
        command.neck = cut(clip(wanted, -90, 90) - me.neck)

    # The world.

    def move(self) -> None:
        pushes = [0j for _ in self.everybody]
        ball_push = 0j
        for i, (player, command) in enumerate(zip(self.players, self.commands, strict=True)):
            if command.kind == "dash":
                pushes[i] = 0.006 * command.value * unit(player.body)
            elif command.kind == "turn":
                noise = 1 + 0.1 * (2 * self.streams.turn.random() - 1)
                player.body = wrap(player.body + noise * command.angle / (1 + 5 * size(player.v)))
            elif command.kind == "kick":
                ball_push += self.kick_push(player, command)
            player.neck = clip(player.neck + command.neck, -90, 90)
        self.step(self.ball, ball_push, 2.7, 3.0, 0.05, 0.94)
        for player, push in zip(self.players, pushes, strict=True):
            self.step(player, push, 1.0, 1.05, 0.1, 0.4)

    def kick_push(self, player: Thing, command: Command) -> complex:
        gap = self.ball.at - player.at
        if size(gap) > REACH:
            return 0j
        push = rate(player, self.ball) * command.value * unit(player.body + command.angle)
        off = abs(wrap(angle_of(gap) - player.body))
        where = 0.5 + 0.25 * (off / 180 + (size(gap) - TOUCH) / 0.7)
        how_fast = 0.5 + 0.5 * size(self.ball.v) / (3.0 * 0.94)
        angle = math.pi * (2 * self.streams.kick.random() - 1)
        amount = self.streams.kick.random() * 0.1 * (command.value / 100) * (where + how_fast)
        return push + amount * complex(math.cos(angle), math.sin(angle))

    def step(
        self, thing: Thing, push: complex, accel_max: float, speed_max: float, noise: float, decay: float
    ) -> None:
        if push:
            thing.v += push if size(push) <= accel_max else push * accel_max / size(push)
            if size(thing.v) > speed_max:
                thing.v *= speed_max / size(thing.v)
        angle = math.pi * (2 * self.streams.movement.random() - 1)
        amount = self.streams.movement.random() * noise * size(thing.v)
        thing.v += amount * complex(math.cos(angle), math.sin(angle))
        thing.at += thing.v
        thing.v *= decay

    def collide(self) -> None:
        things = [self.ball, *self.players]
        hit: set[int] = set()
        for _ in range(10):
            shifts: dict[int, list[complex]] = {}
            for a in range(len(things)):
                for b in range(a + 1, len(things)):
                    reach = TOUCH if a == 0 else 0.6
                    gap = things[b].at - things[a].at
                    if reach * reach - dot(gap, gap) > 1e-9:
                        half = gap / size(gap) * (reach - size(gap)) / 2
                        shifts.setdefault(a, []).append(-half)
                        shifts.setdefault(b, []).append(half)
            if not shifts:
                break
            for k, moves in shifts.items():
                things[k].at += sum(moves) / len(moves)
                hit.add(k)
        for k in hit:
            things[k].v *= -0.1
        self.ball_hit, self.hit = 0 in hit, [1 + i in hit for i in self.everybody]

    def judge(self) -> None:
        def any_reach(team: range) -> bool:
            return any(size(self.ball.at - self.players[i].at) < REACH for i in team)

        w, h = self.config.length_m / 2, self.config.width_m / 2
        if abs(self.ball.at.real) >= w or abs(self.ball.at.imag) >= h:
            self.end = "out"
        elif self.takes >= 4:
            self.end = "taken"
        elif any_reach(self.takers):
            self.takes += 1
        elif any_reach(self.keepers):
            self.takes = 0
        if not self.end:
            self.drop_stuck_ball()

    def drop_stuck_ball(self) -> None:
        gap = self.ball.at - self.stuck_at
        if not size(gap) <= 3:
            self.stuck_at, self.stuck_since = self.ball.at, self.clock
        elif self.clock - self.stuck_since >= 100:
            self.stuck_at, self.stuck_since = self.ball.at, self.clock
            self.ball.v = 0j
            for player in self.players:
                way = player.at - self.ball.at
                if size(way) < 9.45:
                    player.at = self.ball.at + way * 9.45 / size(way)
                    player.v = 0j

    def play_cycle(self, policy: str) -> bool:
        deciding = self.begin()
        return self.finish({i: self.choose(policy, i) for i in deciding})
