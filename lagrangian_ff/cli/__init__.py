"""The command `lagrangian_ff`: identify, compare, diagnose, add, history and more.

`commands` holds one file a command and lists them once; `common` the parts that they share
(options, sources, outputs, progress); `text` the words of their results. Importing this room loads
neither NumPy nor any other library, so that `--help` is quick: the commands import what they need
when they run.
"""
