"""What each game says of itself before any of it is played, and where games are found: entry points
`arl.games`.

A package that has a game names an instance of `GamePlugin` in its metadata,

    [project.entry-points."arl.games"]
    our-game = "our_package.plugin:PLUGIN"

and `[domain] type = "our-game"` in a protocol plays it. The module of a plugin imports no compiled code: a
protocol is read, checked and described without it. `GamePlugin.load` imports the rest (`core.registry.Game`).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from typing import Any, ClassVar

import msgspec

from core.configuration.open_table import OpenTable
from core.configuration.reading import Problem
from core.events import ActionRecord

GROUP = "arl.games"
BUILT_IN = {
    "tetris": "core.tetris.plugin:PLUGIN",
    "keepaway": "core.keepaway.plugin:PLUGIN",
    "gymnasium": "core.interop.gymnasium.plugin:PLUGIN",
}
"""Name to where the program's own games are; found whatever the installation's metadata say."""


class GameError(ValueError):
    """A game is not known or cannot be loaded; the message says which, why and what to do."""


class DomainConfig(OpenTable):
    """Base of what a game is set up by: the table `[domain]` of a protocol, whose tag is the game's name."""

    __slots__ = ()

    @classmethod
    def structs(cls) -> "Mapping[str, type[msgspec.Struct]]":
        """Return the configuration type of each game by the game's name, the program's own first."""
        return _Configurations()


class View(OpenTable):
    """Base of what a game shows: pictures as data, that travel from the learner's process to the screen's."""

    __slots__ = ()

    @classmethod
    def structs(cls) -> Mapping[str, type[msgspec.Struct]]:
        """Return the pictures of each game by the game's name."""
        return _Views()


class GamePlugin(ABC):
    """One game, as protocols, effects and plans know it. Its module imports no compiled code.

    A protocol is a `core.session.protocol.Protocol`. The annotations here say Any, because the modules of
    sessions import this one; those of each game say what it is.
    """

    name: ClassVar[str]
    """As in `[domain] type`, on the command line and in recordings: lower case, digits and '-'."""
    title: ClassVar[str]
    """As in sentences: "Tetris"."""
    config: ClassVar[type[msgspec.Struct]]
    """What it is set up by: a frozen struct that inherits from `DomainConfig`, with `name` as its tag."""
    action: ClassVar[type[ActionRecord]]
    """What is done at a step, as recordings hold it: a frozen struct that inherits from `ActionRecord`."""
    revision: ClassVar[int]
    """Of what the same seed plays: one more whenever that changes. Recordings hold it."""
    learners: ClassVar[tuple[type[msgspec.Struct], ...]]
    """Configuration types of the environment learners that can learn it."""
    human_models: ClassVar[tuple[type[msgspec.Struct], ...]]
    """Configuration types of the human models that can judge its actions."""
    steps: ClassVar[str]
    """What its steps are, in the plural: "pieces"."""
    kernels: ClassVar[int] = 0
    """How many kernels a session compiles before its first game where none is in the cache, counted with the
    default protocol: for the progress of the first start."""
    idle: ClassVar[Mapping[str, str]] = {}
    """Settings outside `[domain]` that have no effect in this game, as dotted paths, each with the reason (""
    where it needs none)."""
    foreign: ClassVar[bool] = False
    """Whether a protocol names rules that are not the plugin's own. Whether they can be played shows only
    when they are tried: this is done before the first page of a session."""
    uses: ClassVar[tuple[Any, ...]] = ()
    """(`core.session.effects.Use`, ...): of the settings in `[domain]`, those that have an effect in some
    sessions only."""

    @abstractmethod
    def default(self) -> Any:
        """Return the protocol of a session without a protocol file."""

    def default_of(self, variant: str) -> Any:
        """Return the default protocol of one of the game's variants: what stands behind the colon in
        "game:variant".

        Raises:
            GameError: the game has no variants.
        """
        raise GameError(f"{self.title} is one game: say `{self.name}`, without `:{variant}`")

    @abstractmethod
    def expected_game_s(self, protocol: Any) -> float:
        """Return how long a watched game is on screen on average, in seconds, > 0."""

    @abstractmethod
    def load(self) -> Any:
        """Return the game itself (`core.registry.Game`); compiled code may be imported."""

    def view(self) -> type[msgspec.Struct]:
        """Return what its pictures are: a frozen struct that inherits from `View`, with `name` as its tag.

        Raises:
            GameError: it has none, so it is played without a screen only.
        """
        raise GameError(f"{self.title} has no pictures: it can be simulated and replayed, not shown")

    def check(self, protocol: Any) -> None:  # noqa: B027 - most games have nothing to add
        """Raise ValueError where a protocol asks for what this game cannot do."""

    def contradictions(self, protocol: Any) -> Iterator[Problem]:
        """Yield what nobody means though each value is in its range: for protocols that are about to be
        run.
        """
        yield from ()

    def departures(self, protocol: Any) -> list[str]:
        """Return in plain sentences where this game does otherwise than the paper, or fills its silence."""
        return []


def game_names() -> dict[str, str]:
    """Return every game's name and where its plugin is, the program's own first, without loading any.

    Raises:
        GameError: two packages have a game of one name.
    """
    found = dict(BUILT_IN)
    for name, value in _installed():
        if found.setdefault(name, value) != value:
            raise GameError(
                f"two games are called {name!r}: {found[name]} and {value}. Uninstall one of their packages"
            )
    return found


def is_game(name: object) -> bool:
    """Return whether there is a game of this name; whether it can be loaded is another question."""
    return name in BUILT_IN or (name != "" and name in game_names())


def plugin_called(name: str) -> GamePlugin:
    """Return the plugin of a game by its name.

    Raises:
        GameError: there is none of that name, its module cannot be imported, or it lacks a part of the
            contract.
    """
    names = BUILT_IN if name in BUILT_IN else game_names()
    if name not in names:
        raise GameError(
            f"no game is called {name!r}; there are {', '.join(names)}. Is the package that brings it "
            f"installed?"
        )
    return _loaded(name, names[name])


def plugin_of(protocol: Any) -> GamePlugin:
    """Return the plugin of the game that a protocol is about."""
    return plugin_called(protocol.game)


def plugins() -> Iterator[GamePlugin]:
    """Yield all plugins that can be loaded, the program's own first. Asking for another by its name says why
    not.
    """
    for name in game_names():
        try:
            yield plugin_called(name)
        except GameError:
            continue


@cache
def _installed() -> tuple[tuple[str, str], ...]:
    # Here, not above: it takes a tenth of a second, and the program's own games are found without it.
    from importlib.metadata import entry_points

    return tuple((point.name, point.value) for point in entry_points(group=GROUP))


@cache
def _loaded(name: str, where: str) -> GamePlugin:
    try:
        module, _, attribute = where.partition(":")
        plugin = getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise GameError(f"the game {name!r} at {where} cannot be loaded: {error}") from error
    wrong = _wrong(plugin, name)
    if wrong:
        raise GameError(f"{where} is no game: {wrong} (docs/extending.md)")
    assert isinstance(plugin, GamePlugin), "this was looked at"
    return plugin


def _wrong(plugin: object, name: str) -> str:
    """Return in which respect something is no plugin of this name; "" where it is one."""
    if not isinstance(plugin, GamePlugin):
        return "it is not an instance of a subclass of core.plugins.GamePlugin"
    needed = ("name", "title", "config", "action", "revision", "learners", "human_models", "steps")
    missing = [part for part in needed if not hasattr(plugin, part)]
    if missing:
        return f"it lacks {', '.join(missing)}"
    if not issubclass(plugin.config, DomainConfig):
        return f"its configuration {plugin.config.__name__} does not inherit from core.plugins.DomainConfig"
    tag = plugin.config.__struct_config__.tag
    if not plugin.name == name == tag:
        return (
            f"its entry point is called {name!r}, its name is {plugin.name!r}, its configuration's tag "
            f"{tag!r}"
        )
    return ""


class _Configurations(Mapping[str, type[msgspec.Struct]]):
    """Name of each game to its configuration type; looked up anew each time."""

    def __getitem__(self, name: str) -> type[msgspec.Struct]:
        if name not in self:
            raise KeyError(name)
        return plugin_called(name).config

    def __contains__(self, name: object) -> bool:
        return is_game(name)

    def __iter__(self) -> Iterator[str]:
        return (plugin.name for plugin in plugins())

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __bool__(self) -> bool:
        return bool(BUILT_IN)


class _Views(Mapping[str, type[msgspec.Struct]]):
    """Name of each game to its pictures; looked up anew each time."""

    def __getitem__(self, name: str) -> type[msgspec.Struct]:
        if not is_game(name):
            raise KeyError(name)
        return plugin_called(name).view()

    def __iter__(self) -> Iterator[str]:
        return (plugin.name for plugin in plugins())

    def __len__(self) -> int:
        return sum(1 for _ in self)
