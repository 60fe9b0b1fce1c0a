"""Compiles what leakref compiles: started once by `conftest`, so that the processes that test need not each do it."""

from leakref import Grid, SeaState, fast
from leakref.methods import METHODS

if __name__ == "__main__":
    sea = SeaState(direction=70, spread=60, length=5).components(3)
    for waves in (sea, sea.rotated(30, (0, 0))):
        fast.realize(waves, Grid((40, 44, 64), (0.8, 0.75, 0.9)), [1.0, 1.4], methods=tuple(METHODS), gravity=1.0)
