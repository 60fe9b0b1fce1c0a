"""Golden values: reading and comparing them, looking whether they are whole, making them and verifying them.

`sets` reads a set and compares with it; `linting` and `beside` look whether all is as it was made; `vectors` defines
the inputs, `stages` how each is computed, `oracle` the same with 40 digits; `entries`, `records` and `making` write
entries, `verifying` computes them again, and `same` says what counts as the same number. `commands` is `leakref
golden`. Nothing but `making` ever writes into a set.
"""
