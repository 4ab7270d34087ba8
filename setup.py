"""Build file of the ament_python package: `pip install .` without ROS, `colcon build` with it."""

from glob import glob

from setuptools import find_namespace_packages, setup

PACKAGE = "seat_gear_dynamics"
SHARE = f"share/{PACKAGE}"

# Each requirement: why it is here, and the lowest version the test suite was run with.
REQUIREMENTS = [
    "numpy>=1.26",  # arrays; 1.26 is what Ubuntu 24.04 (ROS 2 Jazzy) ships
    "scipy>=1.11",  # quadrature of tooth compliance, static equilibrium; 1.11 is Ubuntu 24.04's
    "numba>=0.59",  # compiles the Runge-Kutta kernels for the machine they run on; 0.59 is the first for Python 3.12
    "PyYAML>=6.0.1",  # the system description
    "mcap>=1.2.1",  # writes and reads the log's container
    "zstandard>=0.22",  # compresses the log's chunks (mcap names it as the codec)
    "rosbags>=0.10.9",  # ROS 2 Jazzy message definitions and type hashes, and bag reading
    "rich>=13.7",  # the live terminal view
    "matplotlib>=3.6",  # the report's figures
    "argcomplete>=3.1.4",  # completes the command line in bash, zsh and fish; 3.1.4 is Ubuntu 24.04's
    "cyclonedds>=11.0",  # DDS for the bundled runtime; never imported where rclpy is installed
]

TEST = [
    "pytest>=7.4",  # runs the tests; 7.4 is Ubuntu 24.04's, and colcon test looks for it in this list
    "pytest-timeout>=2.2",  # a process test that hangs fails instead of stopping CI
    "hypothesis>=6.98",  # property tests
]

CALIBRATION = [
    "cma>=4.0",  # covariance matrix adaptation for `seat-gear calibrate`; nothing else needs it
]

PARQUET = [
    "pyarrow>=16",  # Parquet beside the CSV tables of `seat-gear analyze --parquet`
]

CLUSTER = [
    "distributed>=2024.1",  # hands sweeps and maps to a Dask cluster (`--scheduler`); nothing else needs it
]

PEERS = [
    "heyoka>=7.13",  # Taylor series in batches: a peer that benchmarks/ measures against; nothing else needs it
    "jitcode>=1.7.3",  # equations compiled by a C compiler: likewise; needs one, and Python's headers
]

DASHBOARD = [
    "aiohttp>=3.9.1",  # serves `seat-gear dashboard`; 3.9.1 is Ubuntu 24.04's; nothing else needs it
]

DOCS = [
    "sphinx>=9.0",  # builds the site (`scripts/docs`)
    "myst-parser>=5.2",  # its pages are Markdown, with formulas and checked links
    "furo>=2025.12.19",  # its look: light and dark, on a phone, nothing loaded from other hosts
    "latex2mathml>=3.81",  # formulas as MathML, which needs neither a script nor a network
]

DEVELOPMENT = [
    *TEST,
    *CALIBRATION,
    *PARQUET,
    *DASHBOARD,
    *CLUSTER,
    *DOCS,
    "mypy>=1.13",  # types
    "types-PyYAML",  # types of PyYAML
    "ruff>=0.8",  # lint and format
]

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Virtual sensor and rattle warning for car-seat height adjusters",
    license="Apache-2.0",
    python_requires=">=3.11",
    packages=[*find_namespace_packages(include=[f"{PACKAGE}*"]), f"{PACKAGE}.config"],
    package_dir={f"{PACKAGE}.config": "config"},
    package_data={
        f"{PACKAGE}.config": ["*.yaml", "*.npz"],
        PACKAGE: ["py.typed"],
        f"{PACKAGE}.views.dashboard": ["page/*", "page/vendor/*"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (SHARE, ["package.xml"]),
        (f"{SHARE}/config", [*glob("config/*.yaml"), *glob("config/*.npz")]),
        (f"{SHARE}/config/security", glob("config/security/*.xml")),
        (f"{SHARE}/config/layouts", glob("config/layouts/*")),
        (f"{SHARE}/launch", glob("launch/*.launch.py")),
    ],
    install_requires=REQUIREMENTS,
    extras_require={
        "test": TEST,
        "dev": DEVELOPMENT,
        "calibration": CALIBRATION,
        "parquet": PARQUET,
        "dashboard": DASHBOARD,
        "cluster": CLUSTER,
        "peers": PEERS,
        "docs": DOCS,
    },
    zip_safe=False,
    entry_points={
        "console_scripts": [
            f"seat-gear = {PACKAGE}.commands:main",
            f"monitor = {PACKAGE}.nodes.monitor:main",
            f"recorder = {PACKAGE}.nodes.recorder:main",
            f"simulator = {PACKAGE}.nodes.simulator:main",
        ]
    },
)
