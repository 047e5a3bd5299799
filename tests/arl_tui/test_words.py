"""The catalogue of participants' words: none is missing, unused, or has other placeholders than English."""

import ast
import importlib.util
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from string import Formatter

import pytest
from babel.messages.catalog import Catalog

from arl_tui import language
from arl_tui.language import FIXED_KEYS, KEYS_OF_LANGUAGE, LANGUAGES, OWN_KEYS, key_for, tr, trn, use
from arl_tui.own_keys import BOUND, clash_with_feedback, wrong_keys
from arl_tui.widgets.big_letters import big
from core.feedback.keys import KeyConfig

ROOT = Path(__file__).resolve().parents[2]
TRANSLATED = LANGUAGES[1:]


def tool():
    """Return `docs/update_words.py`."""
    spec = importlib.util.spec_from_file_location("update_words", ROOT / "docs" / "update_words.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TOOL = tool()
IN_CODE = TOOL.extracted()


def texts(message) -> list[tuple[str, str]]:
    """Return each English text of a message with its translation; of two, the one for several comes last."""
    if isinstance(message.id, tuple):
        return list(zip(message.id, message.string, strict=True))
    return [(message.id, message.string)]


def messages(catalogue: Catalog):
    return [message for message in catalogue if message.id]


def placeholders(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name}


def tags(text: str) -> Counter[str]:
    return Counter(re.findall(r"\[[^\]]*\]", text))


def test_there_is_a_folder_for_each_language_and_none_more():
    folders = {path.name for path in TOOL.LOCALE.iterdir() if path.is_dir()}
    assert folders == set(TRANSLATED)
    assert LANGUAGES[0] == "en"


@pytest.mark.parametrize("code", TRANSLATED)
def test_no_word_is_missing_and_none_is_left_over(code: str):
    ids = {message.id for message in messages(TOOL.read(code))}
    expected = {message.id for message in messages(IN_CODE)}
    assert ids - expected == set(), "not in the code any more: python docs/update_words.py"
    assert expected - ids == set(), "new in the code: python docs/update_words.py, then translate"
    missing = [message.id for message in messages(TOOL.read(code)) if not TOOL.translated(message.string)]
    assert missing == []
    assert not any(message.fuzzy for message in messages(TOOL.read(code)))


@pytest.mark.parametrize("code", TRANSLATED)
def test_placeholders_and_markup_are_those_of_the_english(code: str):
    for message in messages(TOOL.read(code)):
        for english, translation in texts(message):
            assert placeholders(translation) == placeholders(english), english
            assert tags(translation) == tags(english), english
            assert translation.startswith("\n") == english.startswith("\n"), english
            assert translation.endswith(("\n", " ")) == english.endswith(("\n", " ")), english


@pytest.mark.parametrize("code", TRANSLATED)
def test_the_compiled_catalogue_is_that_of_the_texts(code: str):
    path = TOOL.po_file(code)
    assert path.with_suffix(".mo").read_bytes() == TOOL.compiled(TOOL.read(code)), (
        "python docs/update_words.py"
    )


@cache
def calls() -> tuple[tuple[str, ast.Call, str], ...]:
    """Return every call of a function by its name, with its file."""
    return tuple(_calls())


def _calls() -> Iterator[tuple[str, ast.Call, str]]:
    for folder in TOOL.FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                    yield f"{path.name}:{node.lineno}", node, node.func.id


def test_every_call_gives_what_its_text_asks_for():
    given_by_itself = {"tr": set(), "trn": {"n"}, "judging_text": {"no", "yes", "space"}}
    seen = 0
    for where, node, name in calls():
        first = node.args[0] if node.args else None
        if name not in given_by_itself or not isinstance(first, ast.Constant):
            continue
        if any(keyword.arg is None for keyword in node.keywords):
            continue
        wanted = set().union(*(placeholders(arg.value) for arg in node.args[: TOOL.KEYWORDS[name]]))
        keys = {key for key in wanted if key.startswith("key_")}
        assert {key.removeprefix("key_") for key in keys} <= {*OWN_KEYS, *FIXED_KEYS}, where
        given = {keyword.arg for keyword in node.keywords}
        assert given <= wanted - keys, where
        assert wanted - keys <= given | given_by_itself[name], where
        seen += 1
    assert seen > 100


def test_no_text_is_put_together_before_it_is_looked_up():
    """An f-string or a sum is in no catalogue."""
    for where, node, name in calls():
        if name in TOOL.KEYWORDS:
            for argument in node.args[: TOOL.KEYWORDS[name]]:
                assert not isinstance(argument, ast.JoinedStr | ast.BinOp), where


@pytest.mark.parametrize("code", LANGUAGES)
def test_words_in_big_letters_can_be_drawn(code: str):
    use(code)
    for word in (tr("GOOD"), tr("BAD"), tr("TAKEN BACK")):
        lines = big(word, narrow=True)
        assert len({len(line) for line in lines}) == 1
        # They fit into the narrowest feedback bar, beside the pitch; two words may fall back to small ones.
        assert len(lines[0]) <= 34 or " " in word


@pytest.mark.parametrize("code", LANGUAGES)
def test_titles_fit_into_the_border_of_the_narrowest_board(code: str):
    use(code)
    for title in (tr("Game over"), tr("End of this game"), tr("Game {number}", number=10)):
        assert len(title) <= 16, title


@pytest.mark.parametrize("code", LANGUAGES)
def test_the_programs_own_keys_differ_from_each_other_and_from_those_for_feedback(code: str):
    keys = {**OWN_KEYS, **KEYS_OF_LANGUAGE.get(code, {})}
    assert wrong_keys(keys) == ""
    default = KeyConfig()
    feedback = {default.good, default.bad, default.retract}
    assert not feedback & {keys["pause"], keys["help"], keys["stop"]}
    assert keys["stop_yes"] not in feedback, "a press meant for the agent would end the session"


def test_the_number_chooses_the_word():
    use("de")
    assert trn("one game", "{n} games", 1) == "ein Spiel"
    assert trn("one game", "{n} games", 3) == "3 Spiele"
    assert trn("{n} press left", "{n} presses left", 0) == "noch 0 Drücke"


def test_keys_are_called_as_on_the_keyboard():
    use("de")
    assert "Leertaste" in tr("Press {key_pause} or {key_space} to go on")
    assert language.key_name("ctrl+q") == "Strg+Q"
    use("en")
    assert language.key_name("ctrl+q") == "Ctrl+Q"


def test_an_unknown_language_is_refused():
    with pytest.raises(ValueError, match="choose one of en, de"):
        use("fr")


def test_an_empty_text_is_not_looked_up():
    """The empty text is the head of a gettext catalogue."""
    use("de")
    assert tr("") == ""


def test_changed_keys_are_shown_and_hold_in_the_next_language_too():
    language.change_keys({"pause": "w"})
    use("de")
    assert key_for("pause") == "w"
    assert "[reverse] W [/]" in tr("Press {key_pause} or {key_space} to go on")


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"pause": "ctrl+p"}, "one lower-case letter"),
        ({"pause": "h"}, "pause and help are both 'h'"),
        ({"yes": "q"}, "yes and stop are both 'q'"),
    ],
)
def test_keys_that_cannot_be_told_apart_are_refused(changed: dict[str, str], reason: str):
    assert reason in wrong_keys({**OWN_KEYS, **changed})


def test_a_changed_key_is_none_for_feedback():
    assert "'j' is pause in the settings" in clash_with_feedback({"pause": "j"}, ("j", "f", "u"))
    assert clash_with_feedback({"yes": "j"}, ("j", "f", "u")) == ""


def test_every_binding_with_an_own_key_is_known():
    """A binding that is not listed would stay as it is in English, while the text names another key."""
    found = {}
    for _, node, name in calls():
        identifier = [word.value for word in node.keywords if word.arg == "id"]
        if name == "Binding" and identifier and isinstance(identifier[0], ast.Constant):
            keys = ast.unparse(node.args[0]).strip("'")
            found[identifier[0].value] = "q,ctrl+q,ctrl+c" if keys == "STOP_KEYS" else keys
    listed = {identifier: keys for identifier, (keys, _) in BOUND.items()}
    assert {identifier: found.get(identifier) for identifier in listed} == listed
    of_the_experimenter = ("viewer", "watch", "monitor", "play.", "practice.left", "key-help")
    letters = {identifier for identifier, keys in found.items() if set(keys.split(",")) & set("phqyn")}
    assert {each for each in letters if not each.startswith(of_the_experimenter)} <= set(BOUND)
