"""The naive Keepaway's world: places, physics, referee."""

from __future__ import annotations

import math

from core.keepaway.pitch import KeepawayConfig
from core.keepaway.simulator.match import Streams
from tests.naive.keepaway_things import (
    REACH,
    TOUCH,
    UNKNOWN,
    Command,
    Mind,
    Thing,
    angle_of,
    clip,
    dot,
    rate,
    size,
    unit,
    wrap,
)


class World:
    """The field of a match: who stands where, what commands and collisions do, and what the referee sees."""

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
        if self.is_stuck() and not self.end:
            self.drop_ball()
            self.collide()

    def is_stuck(self) -> bool:
        """Whether the ball has not left 3 m for 100 cycles; looks at the last cycle of an episode, too."""
        moved = not size(self.ball.at - self.stuck_at) <= 3
        over = not moved and self.clock - self.stuck_since >= 100
        if moved or over:
            self.stuck_at, self.stuck_since = self.ball.at, self.clock
        return over

    def drop_ball(self) -> None:
        self.ball.v = 0j
        for player in self.players:
            way = player.at - self.ball.at
            if size(way) < 9.45:
                player.at = self.ball.at + way * 9.45 / size(way)
                player.v = 0j
