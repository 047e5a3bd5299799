"""The naive Keepaway's senses."""

from __future__ import annotations

import math

from tests.naive.keepaway_skills import (
    fastest,
    step_meant,
)
from tests.naive.keepaway_things import (
    REACH,
    UNKNOWN,
    Thing,
    angle_of,
    cross,
    dot,
    nearest_multiple,
    rate,
    size,
    unit,
    wrap,
)
from tests.naive.keepaway_world import World


class Senses(World):
    """What players believe: reckoned in every cycle, seen in two of three, heard with limited vision."""

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
