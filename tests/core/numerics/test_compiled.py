"""The folder of compiled code follows the sources."""

import ast
import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from core.numerics.kernel_files import IN_USE, KEPT_FOLDERS, KernelFiles, _verified, forget_old_folders
from core.numerics.kernel_folder import sources_digest

REPOSITORY = Path(__file__).resolve().parents[3]


def cache_folder(cache_home: Path, *, sources: Path = REPOSITORY) -> Path:
    """Return the folder that a new process chooses for its compiled code."""
    # The folder is the same whether anything is compiled; without the compiler, which takes a second to load.
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache_home), "PYTHONPATH": str(sources)}
    environment |= {"NUMBA_DISABLE_JIT": "1"}
    environment.pop("NUMBA_CACHE_DIR", None)
    script = (
        "from core.numerics.kernel_folder import cache_folder, sources_digest; "
        "print(cache_folder(sources_digest())[0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        env=environment,
        cwd=sources,
        capture_output=True,
        text=True,
        check=True,
    )
    return Path(done.stdout.strip())


def test_equal_sources_share_a_folder_and_other_sources_get_another(tmp_path):
    assert cache_folder(tmp_path) == tmp_path / "arl-tui" / "kernels" / f"{sources_digest()}-{os.getuid()}"
    changed = tmp_path / "sources"
    for package in ("core", "studies"):
        (changed / package).mkdir(parents=True)
        (changed / package / "__init__.py").write_text("")
    numerics = changed / "core" / "numerics"
    numerics.mkdir()
    for name in (
        "__init__",
        "compiled",
        "kernel_dispatch",
        "kernel_files",
        "kernel_folder",
        "kernel_libraries",
    ):
        (numerics / f"{name}.py").write_text((REPOSITORY / "core" / "numerics" / f"{name}.py").read_text())
    before = cache_folder(tmp_path, sources=changed)
    (changed / "studies" / "page.py").write_text("TITLE = 'no kernel here'\n")
    assert cache_folder(tmp_path, sources=changed) == before
    (changed / "studies" / "kernels.py").write_text("from core.numerics.compiled import kernel\n")
    with_kernel = cache_folder(tmp_path, sources=changed)
    assert with_kernel != before
    (changed / "core" / "table.py").write_text("STEPS = 3\n")
    assert cache_folder(tmp_path, sources=changed) not in (before, with_kernel)


def imported_from_studies(source: str) -> set[Path]:
    """Return the files of `studies` that a file's text imports from: modules, or names out of modules."""
    files = set()
    for node in ast.walk(ast.parse(source)):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import | ast.ImportFrom) else []
        if isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{name}" for name in names]
        for name in names:
            if name.startswith("studies."):
                module = REPOSITORY / (name.replace(".", "/") + ".py")
                files.add(module if module.exists() else module.parent.with_suffix(".py"))
    return files


def test_kernels_of_studies_are_fed_by_files_that_the_digest_covers():
    sources = {path: path.read_text(encoding="utf-8") for path in (REPOSITORY / "studies").rglob("*.py")}
    with_kernels = {path for path, source in sources.items() if "core.numerics.compiled" in source}
    assert REPOSITORY / "studies/reaction_time/golden.py" in imported_from_studies(
        sources[REPOSITORY / "studies/reaction_time/kernels.py"]
    )
    for path in with_kernels:
        for fed_by in imported_from_studies(sources[path]):
            assert fed_by in with_kernels, f"{path} takes from {fed_by}, which the digest does not see"


@pytest.mark.jit
def test_processes_that_need_the_same_kernels_at_the_same_time_compile_each_once(tmp_path):
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": str(REPOSITORY)}
    environment.pop("NUMBA_CACHE_DIR", None)
    script = """
from core.numerics.softmax import drawn, softmax
import numpy as np
print("ready", flush=True)
input()
softmax(np.zeros(2), np.zeros(2, dtype=bool), 2, np.empty(2))
drawn(np.array([0.5, 0.5]), 2, 0.7)
print(sum(sum(kernel._cache_misses.values()) for kernel in (softmax, drawn)))
"""
    running = [
        subprocess.Popen(
            [sys.executable, "-c", script],
            env=environment,
            cwd=REPOSITORY,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    for process in running:
        assert process.stdout.readline() == "ready\n"
    for process in running:
        process.stdin.write("\n")
        process.stdin.flush()
    compiled = [int(process.communicate()[0]) for process in running]
    assert sum(compiled) == 2


def run(script: str, **exported: str) -> subprocess.CompletedProcess[str]:
    """Run a script in a new process of this repository."""
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    environment.pop("NUMBA_CACHE_DIR", None)
    return subprocess.run(
        [sys.executable, "-c", script],
        env=environment | exported,
        cwd=REPOSITORY,
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", "NUMBA_CACHE_DIR"])
def test_importing_makes_no_folder_and_removes_none(tmp_path, variable):
    old = tmp_path / "arl-tui" / "kernels"
    for age in range(9):
        (old / f"sources-{age}").mkdir(parents=True)
    before = sorted(tmp_path.rglob("*"))
    done = run(
        "import core.numerics.compiled, core.tetris.sessions, core.keepaway.sessions",
        **{variable: str(tmp_path)},
    )
    assert done.returncode == 0, done.stderr
    assert sorted(tmp_path.rglob("*")) == before


SOFTMAX = """
from core.numerics.softmax import softmax
import numpy as np
out = np.empty(2)
softmax(np.zeros(2), np.zeros(2, dtype=bool), 2, out)
assert out.tolist() == [0.5, 0.5]
print(sum(softmax._cache_misses.values()))
"""


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    """A folder with a compiled kernel."""
    folder = tmp_path_factory.mktemp("filled")
    assert run(SOFTMAX, NUMBA_CACHE_DIR=str(folder)).stdout == "1\n"
    return folder


DAMAGE = {
    "cut by a byte": lambda content: content[:-1],
    "halved": lambda content: content[: len(content) // 2],
    "emptied": lambda content: b"",
    "overwritten": lambda content: b"x" * len(content),
    "flipped": lambda content: content[:-900] + bytes([content[-900] ^ 1]) + content[-899:],
}


@pytest.mark.jit
@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_code_is_compiled_anew_with_a_line_on_why(filled, tmp_path, damage):
    cache = shutil.copytree(filled, tmp_path / "cache")
    files = sorted(cache.rglob("*.kernel"))
    assert len(files) >= 2
    for path in files:
        path.write_bytes(DAMAGE[damage](path.read_bytes()))
    done = run(SOFTMAX, NUMBA_CACHE_DIR=str(cache))
    assert done.stdout == "1\n", done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == len(files)
    assert all("is damaged" in line for line in lines)
    assert sorted(cache.rglob("*.kernel")) == files
    assert all(_verified(path.read_bytes()) is not None for path in files), "the damaged files are replaced"
    if damage == "flipped":  # files that are sound are loaded, whatever was the matter with those before
        again = run(SOFTMAX, NUMBA_CACHE_DIR=str(cache))
        assert (again.stdout, again.stderr) == ("0\n", "")


OWN = """
from core.numerics.compiled import called_kernel, inner_kernel, kernel
@inner_kernel
def third(x): return x / 3.0
@called_kernel
def twice(x): return 2.0 * third(x)
@inner_kernel
def both(x): return twice(x) + third(x)
@kernel
def first(x): return both(x) + 1.0
@kernel
def second(x): return both(x) - 1.0
"""


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """A module with kernels that call one another, and a folder in which one of its two entries is
    compiled.
    """
    folder = tmp_path_factory.mktemp("own")
    (folder / "own.py").write_text(OWN)
    path = os.pathsep.join([str(REPOSITORY), str(folder)])
    done = run("import own; print(own.first(6.0))", NUMBA_CACHE_DIR=str(folder / "cache"), PYTHONPATH=path)
    assert done.stdout == "7.0\n", done.stderr
    return folder, path


@pytest.mark.jit
@pytest.mark.parametrize("damaged", ["third", "twice", "both", "first"])
def test_code_is_not_linked_to_what_was_compiled_anew_since(own, tmp_path, damaged):
    """Kept code knows what it calls by names that compiling gives anew."""
    folder, path = own
    cache = shutil.copytree(folder / "cache", tmp_path / "cache")
    (file,) = cache.rglob(f"own.{damaged}.*.kernel")
    file.write_bytes(file.read_bytes()[:-1])
    done = run(
        "import own; print(own.second(6.0), own.first(6.0))", NUMBA_CACHE_DIR=str(cache), PYTHONPATH=path
    )
    assert (done.returncode, done.stdout) == (0, "5.0 7.0\n"), done.stderr
    assert "is damaged" in done.stderr
    again = run(
        "import own; print(own.second(6.0), own.first(6.0))", NUMBA_CACHE_DIR=str(cache), PYTHONPATH=path
    )
    assert (again.stdout, again.stderr) == ("5.0 7.0\n", "")


@pytest.mark.jit
def test_code_that_others_may_have_written_is_not_loaded(filled, tmp_path):
    cache = shutil.copytree(filled, tmp_path / "cache")
    for path in cache.rglob("*.kernel"):
        path.chmod(0o666)
    done = run(SOFTMAX, NUMBA_CACHE_DIR=str(cache))
    assert done.stdout == "1\n", done.stderr
    assert "another user's" in done.stderr


@pytest.mark.jit
def test_a_place_that_cannot_be_a_folder_is_replaced_by_a_temporary_one(tmp_path):
    blocked = tmp_path / "cache"
    blocked.write_text("a file where a folder should be")
    done = run(SOFTMAX, XDG_CACHE_HOME=str(blocked), TMPDIR=str(tmp_path))
    assert done.stdout == "1\n", done.stderr
    assert done.stderr.count("cannot be kept") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["cache"], (
        "the temporary folder goes with the program"
    )


@pytest.mark.jit
@pytest.mark.parametrize("what", ["os.replace", "fcntl.flock"])
def test_a_full_disk_and_a_file_system_without_locks_only_slow_programs_down(tmp_path, what):
    fails = f"""
import errno, fcntl, os
def fail(*arguments):
    raise OSError(errno.ENOSPC if "{what}" == "os.replace" else errno.ENOLCK, "it fails")
{what} = fail
"""
    done = run(fails + SOFTMAX, NUMBA_CACHE_DIR=str(tmp_path))
    assert done.stdout == "1\n", done.stderr
    assert ("cannot be kept" in done.stderr) == (what == "os.replace")
    assert not list(tmp_path.rglob(".part-*"))


def test_folders_are_their_owners_alone(tmp_path):
    files = KernelFiles(tmp_path / "a" / "b", pruned=False)
    files.save("name", "key", b"code")
    for path in (files.folder, files.folder.parent):
        assert stat.S_IMODE(path.stat().st_mode) == 0o700
    assert stat.S_IMODE(files.path("name", "key").stat().st_mode) == 0o600
    assert files.load("name", "key") == b"code"
    assert files.load("name", "other key") is None


def aged(base: Path, n: int) -> list[Path]:
    """Make folders of compiled code, the youngest first."""
    folders = []
    for age in range(n):
        folder = base / f"sources-{age}"
        folder.mkdir()
        (folder / IN_USE).touch()
        os.utime(folder, (1e9 - age, 1e9 - age))
        folders.append(folder)
    return folders


def test_only_the_folders_used_last_are_kept_when_a_new_one_is_made(tmp_path):
    folders = aged(tmp_path, KEPT_FOLDERS + 3)
    files = KernelFiles(tmp_path / "new", pruned=True)
    files.save("name", "key", b"code")
    left = {path.name for path in tmp_path.iterdir()}
    assert left == {"new"} | {folder.name for folder in folders[: KEPT_FOLDERS - 1]}


def test_a_folder_that_a_running_program_holds_stays(tmp_path):
    oldest = aged(tmp_path, KEPT_FOLDERS + 2)[-1]
    user = KernelFiles(oldest, pruned=False)
    user.save("name", "key", b"code")
    os.utime(oldest, (1, 1))
    assert forget_old_folders(tmp_path) == 1
    assert user.load("name", "key") == b"code"


def test_nothing_beside_a_folder_that_was_chosen_is_touched(tmp_path):
    folders = aged(tmp_path, KEPT_FOLDERS + 3)
    KernelFiles(tmp_path / "new", pruned=False).save("name", "key", b"code")
    assert all(folder.exists() for folder in folders)
