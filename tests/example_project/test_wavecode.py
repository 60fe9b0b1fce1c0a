from wavecode import Code

from leakref.certify import parametrize_with_checks


@parametrize_with_checks(Code, only=["signs", "recovery", "behaviour"])
def test_with_leakref(check):
    check()
