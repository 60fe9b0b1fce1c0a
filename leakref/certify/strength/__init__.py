"""Who tests the tester: wrong codes that must be rejected, right ones that must not, and what an answer gives away.

`faults` plants mistakes in the reference, `variants` makes correct codes that differ from it, `alarms` counts
rejections by chance, `study` puts all of it into one table (`leakref strength`), and `diagnosis` uses the faults the
other way round: which of them explains what a code does; `maps` looks for what else may be simple about it. The
command fails while a fault survives the family meant for it, or a variant is rejected.
"""
