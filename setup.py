"""Package description for pip and for colcon (ament_python)."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "lagrangian_ff"

# Lower bounds are what Ubuntu 24.04, the home of ROS 2 Jazzy, ships, or the oldest release that can
# be installed and passes the tests (constraints-ubuntu-24.04.txt has them all). Upper bounds close
# behind the newest release that passes them.
RUNTIME = [
    "numpy >=1.26.4, <2.5",
    "scipy >=1.11.4, <1.18",
    "numba >=0.58.1, <0.69",
    "threadpoolctl >=3.1, <4",
    "matplotlib >=3.6.3, <3.12",
    "rich >=13.7.1, <16",
    "rosbags >=0.11, <0.12",
    "ruamel.yaml >=0.17.21, <0.20",
    "mcap >=1.2.1, <2",
    "lz4 >=4.3.2, <5",
    "zstandard >=0.22, <0.26",
    "pybullet >=3.2.6, <3.3",
    "joblib >=1.4, <2",
]

EXTRAS = {
    # ROS 2 for a machine that has none. An extra and not a requirement: where ROS is installed from
    # its own packages, pip must neither look for it nor put a second copy beside it, and reading,
    # identifying and diagnosing recordings needs no ROS at all.
    "ros": [
        "ros-jazzy-rclpy[fastrtps] ==7.1.6",
        "ros-jazzy-common-interfaces ==5.3.6",
    ],
    # Reads robot descriptions for models of known robots. Wheels for Linux and macOS; ROS has it as
    # ros-jazzy-pinocchio.
    "urdf": ["pin >=2.7, <5"],
    # Studies on the machines of a Dask cluster.
    "cluster": ["distributed >=2024.8, <2027"],
    # What `make benchmark` compares with.
    "benchmark": ["jax >=0.4.30, <1", "scikit-learn >=1.3, <2"],
    "test": [
        "pin >=2.7, <5",
        "distributed >=2024.8, <2027",
        "pytest >=7.4.4, <10",
        "pytest-xdist >=3.4, <4",
        "hypothesis >=6.98.15, <7",
        "sympy >=1.12, <2",
        "plotly >=5.15, <8",
        "ruff >=0.17.5, <0.18",
        "mypy >=2.4.1, <2.5",
        "colcon-core >=0.21.3, <0.22",
        "colcon-ros >=0.5, <0.6",
    ],
}

setup(
    name=PACKAGE,
    version="0.1.0",
    description="Robot dynamics that are learned, explained and used, inside ROS 2.",
    license="Apache-2.0",
    maintainer="lagrangian_ff maintainers",
    maintainer_email="maintainers@lagrangian-ff.example",
    keywords=["ROS", "robotics", "inverse dynamics", "identification", "feedforward"],
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={"": ["py.typed", "*.pyi", "*.urdf", "*.css", "*.js", "*.html", "*.gz", "*.txt"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    python_requires=">=3.10",
    install_requires=RUNTIME,
    extras_require=EXTRAS,
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "lagrangian_ff = lagrangian_ff.cli.main:main",
            "identify = lagrangian_ff.nodes.identify:main",
            "feedforward = lagrangian_ff.nodes.feedforward:main",
            "monitor = lagrangian_ff.nodes.monitor:main",
            "arm = lagrangian_ff.nodes.arm:main",
        ],
    },
)
