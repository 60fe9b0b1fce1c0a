"""Property-based tests of the reference, and of any implementation.

From a checkout `pytest properties`, from an installed package `pytest --pyargs leakref.properties`; with
`--leakref-implementation package.module:object` or `--leakref-command "program arguments"` they judge that code.

Some are exact, some statistical; each says in its docstring what it allows and where that comes from. What is offered
to another implementation is fair to any correct algorithm: least squares, an optimiser that stops early, single
precision, 8-bit images. The reference is held to the rounding of float64. Properties of the inside of the chain, which
take `modules`, run on the reference only.
"""
