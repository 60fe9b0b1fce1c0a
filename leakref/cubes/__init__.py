"""A user's own cube: reading it, cutting it into pieces, looking at it, and extracting currents from it."""
