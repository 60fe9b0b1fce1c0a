"""Campaigns planned: the errors to expect of a flight, what to do about them, and how they change."""
