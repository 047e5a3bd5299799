"""Skills of the naive Keepaway's players: what one does with the ball, how one moves, and who goes to the
ball."""

from __future__ import annotations

import math

from tests.naive.keepaway_things import (
    REACH,
    TOUCH,
    Command,
    Mind,
    Thing,
    angle_of,
    clip,
    cross,
    dash,
    dot,
    kick,
    nearest,
    rate,
    roll,
    size,
    turn,
    turn_towards,
    unit,
    wrap,
)

# Kicking.


def capped(ball: Thing, direction: float, strongest: float) -> float:
    """Where to push so that a moving ball leaves along this line."""
    side = cross(unit(direction), ball.v)
    if strongest <= abs(side):
        return direction - (90 if side > 0 else -90)
    return direction - math.degrees(math.asin(side / strongest))


def freeze(me: Thing, ball: Thing) -> Command:
    against = kick(me, size(ball.v) / rate(me, ball), angle_of(-ball.v))
    sent = against.value * rate(me, ball) * unit(me.body + against.angle)
    if size(ball.at + ball.v + sent - me.at - me.v) < 0.8 * REACH:
        return against
    gap = ball.at - me.at - me.v
    step = me.at + me.v + gap * min(0.7 * REACH, size(gap) - 0.1) / size(gap) - ball.at
    power = size(step - ball.v) / rate(me, ball)
    if power > 100:
        return kick(me, 100, capped(ball, angle_of(step), 100 * rate(me, ball)))
    return kick(me, power, angle_of(step - ball.v))


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
    straight = capped(ball, direction, strongest)
    if speed > 3:
        if size(ball.v + strongest * unit(straight)) > 0.85 * 2.7:
            return kick(me, 100, straight)
        if rate(me, ball) > 0.85 * 0.027:
            return freeze(me, ball)
        return kick_close(me, ball, 0, 0.16)
    push = speed * unit(direction) - ball.v
    power = size(push) / rate(me, ball)
    if power <= 105 or (power <= 130 and rival_distance < 2):
        return kick(me, power, straight if power > 100 else angle_of(push))
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
        gap = distance_after(me, ball.later(n), n)
        if size(ball.later(n) - mind.meet) < 1 and gap < 0.7 * REACH:
            later = distance_after(me, ball.later(n + 1), n + 1)
            return n + 1 if n < 30 and gap >= 0.5 * REACH > later else n
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
