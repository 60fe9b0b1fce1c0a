"""What is measured of a code and changes no grade: `bias`, how large its errors are, `stress`, what makes them larger.

Both are run in the full profile only and stand on the certificate beside what the reference does in the same seas.
"""

__all__: list[str] = []
