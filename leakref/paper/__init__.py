"""The paper reproduced: its cases as tables, its figures, and sheared currents end to end.

`reproduce` runs cases and writes tables, data and figures; `figures` and `illustrations` draw what the paper shows,
from ensembles or from the golden set; `shear` and `shearfigure`, `depth` and `depthfigure` are cases that the paper
does not have. What the paper says in words is in `claims`.
"""
