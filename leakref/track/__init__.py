"""Bias levels over versions: recorded, compared, drawn."""
