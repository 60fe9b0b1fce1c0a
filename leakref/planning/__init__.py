"""Campaigns planned: the errors to expect of a flight, what to do about them, and how they change.

`plan` simulates a campaign with the chain and the seas of the paper, in metres and seconds; `advice` puts its figures
into sentences; `quantities` reads numbers with units; `figures` draws, and `command` is `leakref plan`. Noise, clouds
and how waves make an image are not simulated: errors are those of leakage and of chance alone.

What to expect of a minute over 128 m by 96 m, with waves of 25 m and a current of 0.5 m/s:

    campaign = Campaign((128.0, 96.0), duration=60.0, peak_wavelength=25.0, speed=0.5)
    best = plan(campaign).best
    print(best.wavelengths, best.bias, best.trusted)
"""
