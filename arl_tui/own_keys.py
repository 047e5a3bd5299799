"""Which bindings of Textual belong to the program's own keys, so that a language or a user can change them.

The keys themselves are in `arl_tui.language.OWN_KEYS`; texts name them by `{key_pause}` and the like, so what
is shown follows. Keys for feedback are the protocol's (`core.feedback.keys.KeyConfig`).
"""

from collections.abc import Collection, Mapping

from arl_tui.language import OWN_KEYS, keys_in_use

LEAVE = "q,ctrl+q,ctrl+c"
BOUND: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "pause.back": ("p,space,enter,escape", ("pause",)),
    "trial.pause": ("p,q,f1,ctrl+q,ctrl+c", ("pause", "stop")),
    "practice.pause": ("p", ("pause",)),
    "practice.help": ("h,f1", ("help",)),
    "practice.quit": (LEAVE, ("stop",)),
    "practice.new": ("n", ("new",)),
    "help.back": ("h,f1,space,enter,escape", ("help",)),
    "tetris-help.back": ("h,f1,space,enter,escape", ("help",)),
    "tetris-help.stop": (LEAVE, ("stop",)),
    "practice-help.back": ("h,f1,space,enter,escape", ("help",)),
    "practice-help.stop": (LEAVE, ("stop",)),
    "keeper.pause": ("p,space", ("pause",)),
    "keeper.help": ("h,f1", ("help",)),
    "keeper.quit": (LEAVE, ("stop",)),
    "small.stop": (LEAVE, ("stop",)),
    "welcome.leave": (LEAVE, ("stop",)),
    "closing.leave": ("enter,q,escape,ctrl+q,ctrl+c", ("stop",)),
    "page.no": (LEAVE, ("stop",)),
    "hindrance.yes": ("y", ("yes",)),
    "hindrance.no": ("n,q,ctrl+q,ctrl+c", ("no", "stop")),
    "old.continue": ("c", ("continue",)),
    "old.new": ("n,enter", ("new",)),
    "summary.leave": ("enter,q,ctrl+q,ctrl+c", ("stop",)),
    "stop.yes": ("y", ("stop_yes",)),
    "stop.no": ("n,space,enter,escape", ("no",)),
    "study.stop": (LEAVE, ("stop",)),
    "study-stop.yes": ("y", ("stop_yes",)),
    "study-stop.no": ("n,escape,enter", ("no",)),
    "consent.yes": ("y", ("yes",)),
    "consent.no": ("n", ("no",)),
    "decline.no": ("b,escape", ("back",)),
    "notice.leave": (LEAVE, ("stop",)),
    "home.back": ("q,escape,ctrl+q,ctrl+c", ("stop",)),
}
"""Id of a binding, its keys in English, and which of the program's own keys are among them."""
TOGETHER: tuple[tuple[str, ...], ...] = (
    ("pause", "help", "stop"),
    ("yes", "no", "stop"),
    ("stop_yes", "no"),
    ("new", "continue"),
    ("back",),
)
"""Keys that are to be pressed on the same page, and so differ."""


def keymap() -> dict[str, str]:
    """Return the bindings that are not those of English, for `textual.app.App.set_keymap`."""
    now = keys_in_use()
    changed = {}
    for binding, (keys, actions) in BOUND.items():
        new = {OWN_KEYS[action]: now[action] for action in actions}
        translated = ",".join(new.get(key, key) for key in keys.split(","))
        if translated != keys:
            changed[binding] = translated
    return changed


def wrong_keys(keys: Mapping[str, str]) -> str:
    """Return why the program's own keys cannot be so; "" where they can.

    Args:
        keys: all of them, by name.
    """
    for name, key in keys.items():
        if len(key) != 1 or not key.isascii() or not key.islower():
            return f"{name} = {key!r}: expected one lower-case letter a-z"
    for group in TOGETHER:
        for place, name in enumerate(group):
            for other in group[:place]:
                if keys[name] == keys[other]:
                    return (
                        f"{other} and {name} are both {keys[name]!r}, and are asked for on the same page: "
                        f"give one of them another letter"
                    )
    return ""


def clash_with_feedback(changed: Mapping[str, str], feedback: Collection[str]) -> str:
    """Return which of the user's own keys is one for feedback; "" where none is.

    Args:
        changed: keys that the user has set, by name.
        feedback: keys that mean something to the agent.
    """
    for name in ("pause", "help", "stop"):
        if changed.get(name) in feedback:
            return (
                f"the key {changed[name]!r} is {name} in the settings and a key for feedback in the "
                f"protocol: change one of them"
            )
    return ""
