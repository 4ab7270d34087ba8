"""Where generated source is kept between processes: the one module of the core that writes a file.

Numba keeps machine code only for functions that stand in a file, beside which it puts its own. So the source goes to
a cache folder under a name that tells its contents. Where no folder can be written to, as with a read-only home, it is
compiled in memory for each process instead.
"""

import sys
from hashlib import sha256
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from tempfile import NamedTemporaryFile
from types import ModuleType
from typing import Any

import numba
from numba.misc.appdirs import AppDirs

from seat_gear_dynamics.motion.compiling import Announce, announced

COMPILING = "Compiling the lane kernel for this machine; this takes some seconds, once."


def cache_folder() -> Path:
    """Return the folder for generated source: in NUMBA_CACHE_DIR if that is set, else in the platform's for caches."""
    settings: Any = numba.config  # numba and its helpers carry no types
    folders: Any = AppDirs
    given = settings.CACHE_DIR
    return Path(given) / "seat_gear_dynamics" if given else Path(folders("seat_gear_dynamics", False).user_cache_dir)


def kept_module(text: str, text_in_memory: str, *, rests_on: str, announce: Announce | None) -> ModuleType:
    """Return the module that `text` makes, from its file in the cache folder, which is written if need be.

    text_in_memory: the same for a process that can keep no file. rests_on: further text on which its machine code
    depends. `announce` gets a sentence when it is really compiled. The file holds nothing but `text`, which is looked
    at before it is run: a damaged one is written anew.
    """
    name = f"seat_gear_lanes_{sha256((text + rests_on).encode()).hexdigest()[:20]}"
    with announced(announce, COMPILING):
        try:
            path = cache_folder() / f"{name}.py"
            if not path.is_file() or path.read_text(encoding="utf-8", errors="replace") != text:
                _write(path, text)
            return _load(name, path)
        except (OSError, RuntimeError):  # no home, no room or no right to write; numba tells the last as a RuntimeError
            module = ModuleType(name)
            exec(compile(text_in_memory, f"<{name}>", "exec"), module.__dict__)
            return module


def _write(path: Path, text: str) -> None:
    """Put the file in place at one stroke, so that another process never reads half of it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with NamedTemporaryFile("w", encoding="utf-8", dir=path.parent, suffix=".tmp", delete=False) as file:
        file.write(text)
    Path(file.name).replace(path)


def _load(name: str, path: Path) -> ModuleType:
    spec = spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules[name] = module  # numba finds the functions that it takes from its cache by their module's name
    spec.loader.exec_module(module)
    return module
