"""The package as it is installed: what is in the wheel, that it runs from there, and what package.xml declares."""

import os
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import pytest

from seat_gear_dynamics import __version__

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    source = tmp_path_factory.mktemp("source")
    # From a copy of what git tracks: a build leaves folders behind, and must not find more than a clone has.
    archive = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, check=True, capture_output=True).stdout
    for name in filter(None, archive.decode().split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(source)]
    subprocess.run(command, check=True)
    return next(folder.glob("*.whl"))


def test_the_wheel_holds_the_description_the_stand_ins_and_the_ros_files(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert "seat_gear_dynamics/config/height_adjuster.yaml" in names
    assert "seat_gear_dynamics/runtime/stand_in/rclpy/__init__.py" in names
    assert "seat_gear_dynamics/py.typed" in names
    data = f"seat_gear_dynamics-{__version__}.data/data/share/"
    assert f"{data}ament_index/resource_index/packages/seat_gear_dynamics" in names
    for name in ("package.xml", "launch/bench.launch.py", "config/height_adjuster.yaml"):
        assert f"{data}seat_gear_dynamics/{name}" in names


def test_the_wheel_runs_away_from_the_checkout(wheel: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    code = (
        "import seat_gear_dynamics as s, numpy as np; system = s.load_system();"
        "assert s.__file__.startswith(__import__('os').environ['PYTHONPATH']);"
        "print(np.isfinite(system.derivative(0.0, system.static_state())).all())"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.stdout.strip() == "True", done.stderr


def test_versions_agree() -> None:
    xml = ElementTree.parse(ROOT / "package.xml").getroot()
    assert xml.findtext("version") == __version__
    assert f'version="{__version__}"' in (ROOT / "setup.py").read_text()
    assert f"## {__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_package_xml_is_format_3_of_ament_python_and_names_every_ros_package_that_is_imported() -> None:
    xml = ElementTree.parse(ROOT / "package.xml").getroot()
    assert xml.get("format") == "3"
    assert xml.findtext("export/build_type") == "ament_python"
    declared = {element.text for element in xml if element.tag.endswith("depend")}
    imported: set[str] = set()
    for folder in ("nodes", "commands"):
        for path in (ROOT / "seat_gear_dynamics" / folder).glob("*.py"):
            imported |= set(re.findall(r"^(?:from|import) (\w+)", path.read_text(), flags=re.MULTILINE))
    ros = {
        name for name in imported if name.startswith("rclpy") or name.endswith(("_msgs", "_srvs", "_interfaces", "_py"))
    }
    assert ros <= declared


def test_every_dependency_says_why_and_since_when() -> None:
    lines = (ROOT / "setup.py").read_text().splitlines()
    requirements = [line for line in lines if re.match(r'    "[\w-]+(>=[\d.]+)?",', line)]
    assert len(requirements) > 10
    for line in requirements:
        assert "#" in line, f"no reason: {line}"
        assert ">=" in line or "types-" in line, f"no lower bound: {line}"


def test_the_tools_are_set_strict() -> None:
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    assert tools["mypy"]["strict"] is True
    assert "scripts/test" in (ROOT / ".ci" / "run").read_text()
    assert "scripts/test" in (ROOT / "README.md").read_text()
