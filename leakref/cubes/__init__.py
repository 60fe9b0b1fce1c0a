"""A user's own cube: reading it, cutting it into pieces, looking at it, and extracting currents from it.

Reading: `asked` is what was asked for and what is then assumed, `reading` the way from a file to a checked
`cube.Cube`; `formats`, `matlab`, `hdf` and `images` read files that nobody trusts (`suspicion`), `deferred` what is
larger than memory; `orders` tells which variable and which axis is which, `coordinates` their steps and units,
`mending` lost and doubled frames and holes. `files` makes cubes from the paper's cases and writes them.

Measuring: `measuring` is the order of it, `blocks` transforms cubes that are larger than memory, `contrast` and
`causes` say whether there is a dispersion shell and if not why, `screen` is the paper's test for leakage.
`wavenumbers`, `figures` and `reporting` are what their names say, `exporting` and `commands` are `leakref export` and
`leakref extract`. The chain itself is elsewhere, and no file is ever changed here but those that are asked to be
written.
"""
