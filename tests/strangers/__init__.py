"""Codes that share no line with leakref: what its fairness and its diagnosis are measured on."""
