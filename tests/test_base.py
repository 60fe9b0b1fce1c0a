"""The one kind of refusal, and the gate that numbers pass."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from leakref import LeakrefError
from leakref._base import finite, positive


def test_error_names_call_fault_and_remedy_and_is_a_value_error():
    error = LeakrefError("call", "fault", "remedy")
    assert str(error) == "call: fault; remedy."
    assert isinstance(error, ValueError)


def test_error_survives_the_way_back_from_a_worker():
    back = pickle.loads(pickle.dumps(LeakrefError("call", "fault", "remedy")))
    assert (type(back), back.call, back.fault, back.remedy, str(back)) == (
        LeakrefError,
        "call",
        "fault",
        "remedy",
        "call: fault; remedy.",
    )


@pytest.mark.parametrize(
    ("value", "ndim", "fault"),
    [
        ([1.0, np.nan], None, "1 of 2 values that are not finite"),
        ([np.nan, np.inf, 2.0], None, "2 of 3 values"),
        ([np.inf, -np.inf], None, "2 of 2 values"),  # whose sum is NaN: no warning may slip out either
        (np.inf, 0, "1 of 1 values"),
        ([1j], None, "complex"),
        (["a"], None, "not numeric"),
        (None, 1, "v "),
        ([[1.0], [1.0, 2.0]], None, "not numeric"),
        ([[1.0]], 1, "shape (1, 1), 2 dimensions"),
        (1.0, 2, "0 dimensions"),
    ],
)
def test_finite_refuses(value, ndim, fault):
    with pytest.raises(LeakrefError) as caught:
        finite("the call", "v", value, ndim)
    assert str(caught.value).startswith("the call: v ")
    assert fault in caught.value.fault


def test_finite_accepts_large_samples_whose_sum_overflows():
    assert finite("call", "v", [1e308, 1e308]).tolist() == [1e308, 1e308]


def test_finite_refuses_masked_samples_rather_than_reading_what_the_mask_hides():
    with pytest.raises(LeakrefError):
        finite("call", "v", np.ma.masked_array([1.0, 9.97e36], mask=[False, True]))


def test_finite_gives_float64_and_no_copy_of_float64():
    array = np.ones(3)
    assert finite("call", "v", array) is array
    assert finite("call", "v", np.ones(3, dtype=np.int16)).dtype == np.float64
    assert finite("call", "v", [], 1).shape == (0,)


@pytest.mark.parametrize("value", [0, -1.0, np.nan, np.inf, [1.0, 0.0], [2.0, -3.0], "a"])
def test_positive_refuses_and_names_the_value(value):
    with pytest.raises(LeakrefError, match=r"call: size\b"):
        positive("call", fine=1.0, size=value)


def test_positive_accepts_numbers_and_sequences():
    assert positive("call", a=1e-59, b=[1, 2.5], c=np.float32(3)) is None
