"""The paper reproduced: its cases as tables, its figures, and sheared currents end to end."""
