"""How a code under test is reached: what it declares, in whose frame it counts, and the programs it runs in."""
