"""Golden values, numbered sets that other implementations are certified against."""
