"""The paper reproduced: its cases as tables, its figures, sheared currents end to end, and depths that are inferred.

`reproduce` runs cases and writes tables, data and figures; `figures` and `illustrations` draw what the paper shows,
from ensembles or from the golden set; `shear` and `shearfigure`, `depth` and `depthfigure` are cases that the paper
does not have. `inferred`, `inferredtables` and `inferredfigure` answer what leakage does to a depth, which the paper
leaves open. What the paper says in words is in `claims`.
"""
