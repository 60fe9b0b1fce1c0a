"""Property-based tests, also from an installed package: `pytest --pyargs leakref.properties`."""
