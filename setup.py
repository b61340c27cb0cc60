"""Package description for pip and colcon (ament_python)."""

from glob import glob

from setuptools import find_packages, setup

PACKAGE = "lagrangian_ff"

setup(
    name=PACKAGE,
    version="0.1.0",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={PACKAGE: ["py.typed", "arm/*.urdf"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (f"share/{PACKAGE}", ["package.xml"]),
        (f"share/{PACKAGE}/config", glob("config/*.yaml")),
        (f"share/{PACKAGE}/launch", glob("launch/*.launch.py")),
    ],
    python_requires=">=3.10",
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "lagrangian_ff = lagrangian_ff.cli.main:main",
            "identify = lagrangian_ff.nodes.identify:main",
            "feedforward = lagrangian_ff.nodes.feedforward:main",
            "arm = lagrangian_ff.nodes.arm:main",
        ],
    },
)
