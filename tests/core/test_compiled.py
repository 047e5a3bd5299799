"""The folder of compiled code follows the sources."""

import os
import re
import subprocess
import sys
from pathlib import Path

from core.compiled import KEPT_CACHES, _forget_old_caches, _sources_digest

REPOSITORY = Path(__file__).resolve().parents[2]


def cache_folder(cache_home: Path, *, sources: Path = REPOSITORY) -> Path:
    """Return the folder that a new process chooses for its compiled code."""
    environment = {**os.environ, "XDG_CACHE_HOME": str(cache_home), "PYTHONPATH": str(sources)}
    environment.pop("NUMBA_CACHE_DIR", None)
    script = "import core.compiled, os; print(os.environ['NUMBA_CACHE_DIR'])"
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
    (changed / "core" / "compiled.py").write_text((REPOSITORY / "core" / "compiled.py").read_text())
    before = cache_folder(tmp_path, sources=changed)
    (changed / "studies" / "page.py").write_text("TITLE = 'no kernel here'\n")
    assert cache_folder(tmp_path, sources=changed) == before
    (changed / "studies" / "kernels.py").write_text("from core.compiled import kernel\n")
    with_kernel = cache_folder(tmp_path, sources=changed)
    assert with_kernel != before
    (changed / "core" / "table.py").write_text("STEPS = 3\n")
    assert cache_folder(tmp_path, sources=changed) not in (before, with_kernel)


def test_kernels_of_studies_are_fed_by_files_that_the_digest_covers():
    sources = {path: path.read_text(encoding="utf-8") for path in (REPOSITORY / "studies").rglob("*.py")}
    with_kernels = {path for path, source in sources.items() if "core.compiled" in source}
    assert with_kernels
    for path in with_kernels:
        for module in re.findall(
            r"^from (studies[\w.]+) import|^import (studies[\w.]+)", sources[path], re.MULTILINE
        ):
            fed_by = REPOSITORY / ("".join(module).replace(".", "/") + ".py")
            assert fed_by in with_kernels, f"{path} takes from {fed_by}, which the digest does not see"


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
