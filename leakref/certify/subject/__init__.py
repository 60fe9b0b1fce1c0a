"""How a code under test is reached: what it declares, in whose frame it counts, and the programs it runs in.

A check speaks to a `Subject` (`frames`), which knows the frame and the units of the code from its `Declaration`. The
work is done in this process (`inprocess`) or in a program of its own (`protocol`, over `child` and `exchange`, with
`guardian` and `memory` to keep it within limits). Nothing here knows what is right: that is for the checks.
"""
