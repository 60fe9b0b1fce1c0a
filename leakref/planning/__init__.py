"""Campaigns planned: the errors to expect of a flight, what to do about them, and how they change.

`plan` simulates a campaign with the chain and the seas of the paper, in metres and seconds; `advice` puts its figures
into sentences; `quantities` reads numbers with units; `figures` draws, and `command` is `leakref plan`. Noise, clouds
and how waves make an image are not simulated: errors are those of leakage and of chance alone.
"""
