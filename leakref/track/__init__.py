"""Bias levels over versions: recorded, compared, drawn.

`tracking` measures the errors of a version, `history` keeps them in a file of JSON lines, `changes` compares two
versions, `timings` their speed, `page` draws what there is, and `falsealarms` measures how far the comparisons can be
trusted. `commands` is `leakref track`. Nothing here says whether a code is right: that is certification.

What the commands do, in Python:

    series, said = measure(InProcess(implementation), [scene("broad")], range(100))
    append(path, fields("v2", "mine", {"name": "mine", "version": "2"}, source, series))
    before, after = (
        [Series.read(one) for one in read(path).entry(name).record["measurements"]] for name in ("previous", "last")
    )
    print(compare(before, after).worse)
"""
