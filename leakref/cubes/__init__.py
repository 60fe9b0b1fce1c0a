"""A user's own cube: reading it, cutting it into pieces, looking at it, and extracting currents from it.

`formats` reads files that nobody trusts, `files` turns them into a checked `Cube` and writes cubes, `blocks` transforms
cubes that are larger than memory, `screen` is the paper's test for leakage, `wavenumbers` and `figures` are what its
names say, `exporting` and `commands` are `leakref export` and `leakref extract`. The chain itself is elsewhere, and no
file is ever changed here but those that are asked to be written.
"""
