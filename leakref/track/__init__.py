"""Bias levels over versions: recorded, compared, drawn.

`tracking` measures the errors of a version, `history` keeps them in a file of JSON lines, `changes` compares two
versions, `timings` their speed, `page` draws what there is, and `falsealarms` measures how far the comparisons can be
trusted. `commands` is `leakref track`. Nothing here says whether a code is right: that is certification.
"""
