"""The folder of compiled code follows the sources."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.numerics.compiled import KEPT_CACHES, _forget_old_caches, _sources_digest

REPOSITORY = Path(__file__).resolve().parents[2]


def cache_folder(cache_home: Path, *, sources: Path = REPOSITORY) -> Path:
    """Return the folder that a new process chooses for its compiled code."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache_home), "PYTHONPATH": str(sources)}
    environment.pop("NUMBA_CACHE_DIR", None)
    script = "import core.numerics.compiled, os; print(os.environ['NUMBA_CACHE_DIR'])"
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
    assert cache_folder(tmp_path) == tmp_path / "arl-tui" / "kernels" / _sources_digest()
    changed = tmp_path / "sources"
    for package in ("core", "studies"):
        (changed / package).mkdir(parents=True)
        (changed / package / "__init__.py").write_text("")
    compiled = changed / "core" / "numerics" / "compiled.py"
    compiled.parent.mkdir()
    (compiled.parent / "__init__.py").write_text("")
    compiled.write_text((REPOSITORY / "core" / "numerics" / "compiled.py").read_text())
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
print(sum(sum(kernel.stats.cache_misses.values()) for kernel in (softmax, drawn)))
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


def test_a_read_only_cache_is_replaced_by_a_temporary_folder(tmp_path):
    blocked = tmp_path / "cache"
    blocked.write_text("a file where a folder should be")
    assert not cache_folder(blocked).is_relative_to(blocked)


def test_only_the_folders_used_last_are_kept(tmp_path):
    for age in range(KEPT_CACHES + 3):
        folder = tmp_path / f"sources-{age}"
        folder.mkdir()
        os.utime(folder, (1000 - age, 1000 - age))
    _forget_old_caches(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {f"sources-{age}" for age in range(KEPT_CACHES)}
