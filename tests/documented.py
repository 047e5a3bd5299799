"""The blocks of code in README and docs, and the marks before them: comments that say how each is run.

A block of `sh` or `python` without a mark is run as it stands, in the order of its page, in a folder of the
page's own. A line `pip install 'arl-tui[EXTRA]'` is not run: what it asks for has to be installed already.

- `first: COMMANDS`: commands that are run before; they make what the reader has already.
- `then: COMMANDS`: commands that are run afterwards; they fail where the block did not do what it should.
- `with: OLD = NEW; ...`: texts that are replaced before the block is run: a placeholder, a number of hours.
- `needs data: FILE`: a file below ARL_DATA that is not ours to ship; without it the block is skipped.
- `in a terminal: SEEN > KEYS; ...`: the block is typed in a terminal of 80 x 24. When SEEN stands on the
  screen (blanks do not matter) KEYS are pressed, in this order; then the block has to leave with status 0.
- `in the background until: TEXT`: each line is a program that runs until the end of the page. It has started
  when it has printed TEXT.
- `saved as: FILE`: the block is a file, which is written into the page's folder.
- `a piece of: FILE; run by TEST`: the block stands word for word in FILE, which a test runs.
- `settings of: WHAT`: a piece of TOML that is no protocol: of a study, this computer, or a package.
- `printed by: COMMANDS`: output; each of its lines is printed by COMMANDS, or by `the block before`.
- `run by: TEST`: another test reads the page and runs the block. Anywhere on a page, `all blocks are run by:
  TEST` says it of each.
- `not run here: REASON; TEST`: the block is not run, and TEST checks what can be checked.

`$REPOSITORY` is the folder of the repository, FREE_PORT a port of this machine.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
DOCS = REPOSITORY / "docs"
PAGES = [REPOSITORY / "README.md", *sorted(DOCS.rglob("*.md"))]
FENCE = re.compile(
    r"^(?P<indent> *)(?P<fence>`{3,}|~{3,})(?P<language>[^\n`]*)\n(?P<text>.*?)^(?P=indent)(?P=fence) *$",
    re.DOTALL | re.MULTILINE,
)
COMMENT = re.compile(r"<!--\s*(?P<words>(?:(?!-->).)*?)\s*-->", re.DOTALL)
COMMENTS_AT_THE_END = re.compile(r"(?:<!--(?:(?!-->).)*-->\s*)+\Z", re.DOTALL)
MARKS = frozenset(re.findall(r"^- `([a-z ]+):", __doc__, re.MULTILINE))
"""The names of all marks."""
ELSEWHERE = ("run by", "not run here")
"""Marks of blocks that are left to other tests."""
OF_A_PAGE = re.compile(r"<!-- all blocks are run by: (\S+) -->")


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    page: Path
    line: int
    language: str
    text: str
    marks: tuple[tuple[str, str], ...]
    """Name and value of each mark before it, in order."""

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(REPOSITORY)}:{self.line}"

    def mark(self, name: str) -> str:
        """Return the value of a mark; "" where the block does not have it."""
        return dict(self.marks).get(name, "")

    @property
    def elsewhere(self) -> bool:
        """Whether the block is left to another test."""
        return any(self.mark(name) for name in ELSEWHERE)

    @property
    def commands(self) -> str:
        """What is run: the text, with the replacements of its mark."""
        text = self.text
        for old, new in pairs(self.mark("with"), " = "):
            assert old in text, f"{self.where}: there is no {old!r} to replace"
            text = text.replace(old, new)
        return text


def pairs(value: str, between: str) -> list[tuple[str, str]]:
    """Split the value of a mark at semicolons, and each part in two."""
    parts = [part.partition(between) for part in re.split(r";\s+", value) if part]
    assert all(sign for _, sign, _ in parts), f"{value!r}: each part has {between!r}"
    return [(one.strip(), other.strip()) for one, _, other in parts]


def named_tests(words: str) -> list[Path]:
    """Return the files of tests that a mark names."""
    return [REPOSITORY / name for name in re.findall(r"\btests/[\w/]+\.py\b", words)]


def blocks_of(page: Path) -> Iterator[Block]:
    text = page.read_text(encoding="utf-8")
    of_all = tuple(("run by", test) for test in OF_A_PAGE.findall(text))
    for found in FENCE.finditer(text):
        before = text[: found.start()]
        comments = COMMENTS_AT_THE_END.search(before)
        words = (
            [" ".join(each["words"].split()) for each in COMMENT.finditer(comments[0])] if comments else []
        )
        marks = tuple((name, value) for name, _, value in (each.partition(": ") for each in words))
        body = re.sub(f"^{found['indent']}", "", found["text"], flags=re.MULTILINE)
        language = found["language"].strip()
        if language != "text":
            marks += of_all
        yield Block(page, before.count("\n") + 1, language, body, marks)


def extras_installed() -> list[str]:
    """Return what pages say to install from inside an environment: `arl-tui[gym]` and others, in order."""
    pages = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    return sorted(set(re.findall(r"pip install '([^']+)'", pages)))


BLOCKS = [block for page in PAGES for block in blocks_of(page)]
