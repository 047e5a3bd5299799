"""Keepaway written for reading: one object per player, no compiled code, no short cuts.

Follows the draws of `core.keepaway` and must agree with it to rounding, cycle by cycle.
"""

from __future__ import annotations

import math

from tests.naive.keepaway_senses import Senses
from tests.naive.keepaway_skills import (
    cone,
    cycles_to_ball,
    go_to_ball,
    hold,
    keeper_to_go,
    move_to,
    pass_to,
    step_meant,
)
from tests.naive.keepaway_things import (
    REACH,
    Command,
    Mind,
    angle_of,
    clip,
    cut,
    dot,
    nearest,
    size,
    turn,
    turn_towards,
    wrap,
)


class NaiveMatch(Senses):
    """A match of `core.keepaway.simulator.match.Match`, cycle by cycle: its players decide and act."""

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

    def play_cycle(self, policy: str) -> bool:
        deciding = self.begin()
        return self.finish({i: self.choose(policy, i) for i in deciding})
