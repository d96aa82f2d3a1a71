"""The digest of a function changes with all that its machine code depends on, and with nothing else."""

from types import ModuleType

import numpy as np
import pytest

from omnimate.vehicle.code_digest import digest_of, references_of
from omnimate.vehicle.compiled import compiled

CALLER = "def caller(x):\n    return callee(x) + LIMIT\n"
CALLEE = "def callee(x):\n    return helper(x) * 2.0\n"
HELPER = "def helper(x):\n    return x + 1.0\n"


def function_of(source, name="caller", **scope):
    exec(compile(source, f"<{name}>", "exec"), scope)
    return scope[name]


def caller_of(caller=CALLER, callee=CALLEE, helper=HELPER, limit=1.0, wrap=compiled):
    inner = function_of(helper, "helper")
    middle = function_of(callee, "callee", helper=wrap(inner))
    return function_of(caller, callee=wrap(middle), LIMIT=limit)


def test_the_same_content_has_the_same_digest_wherever_it_is_written():
    moved = f"# a comment\n\n\n{CALLER}"
    assert digest_of(caller_of()) == digest_of(caller_of(caller=moved))


def test_a_function_that_moved_to_another_module_has_another_digest():
    """numba's cache imports the module of each function by name: the former one may be gone."""
    one, other = (
        function_of(HELPER, "helper", __name__=module) for module in ("omnimate.one", "omnimate.other")
    )
    assert digest_of(one) != digest_of(other)
    assert digest_of(caller_of(wrap=lambda _: one)) != digest_of(caller_of(wrap=lambda _: other))


@pytest.mark.parametrize(
    "change",
    [
        {"caller": CALLER.replace("+", "-")},
        {"callee": CALLEE.replace("2.0", "3.0")},
        {"helper": HELPER.replace("+", "-")},
        {"limit": 2.0},
        {"limit": np.array([1.0, 2.0])},
        {"limit": np.array([1.0, 3.0])},
        {"limit": (1.0, 2.0)},
    ],
)
def test_a_change_of_the_code_of_a_callee_or_of_a_constant_changes_it(change):
    assert digest_of(caller_of(**change)) != digest_of(caller_of())


def test_arrays_of_different_content_differ_although_their_short_text_is_the_same():
    one, other = np.zeros(5000), np.zeros(5000)
    other[2500] = 1.0
    assert repr(one) == repr(other)
    assert digest_of(caller_of(limit=one)) != digest_of(caller_of(limit=other))


def test_a_plain_callee_counts_as_a_marked_one():
    assert digest_of(caller_of(wrap=lambda function: function)) == digest_of(caller_of())


def test_a_constant_that_is_read_from_a_module_counts():
    def reader_of(value):
        constants = ModuleType("constants")
        constants.LIMIT = value
        return function_of("def caller(x):\n    return x + constants.LIMIT\n", constants=constants)

    assert digest_of(reader_of(1.0)) == digest_of(reader_of(1.0))
    assert digest_of(reader_of(1.0)) != digest_of(reader_of(2.0))


def test_the_variables_of_the_functions_around_it_count():
    def adder(amount):
        return lambda x: x + amount

    assert digest_of(adder(1.0)) == digest_of(adder(1.0))
    assert digest_of(adder(1.0)) != digest_of(adder(2.0))


def test_functions_that_call_each_other_have_one():
    scope = {}
    exec(
        "def even(n):\n    return n == 0 or odd(n - 1)\ndef odd(n):\n    return n != 0 and even(n - 1)\n",
        scope,
    )
    assert digest_of(scope["even"]) != digest_of(scope["odd"])


def test_an_attribute_is_no_reference_to_a_global_of_the_same_name():
    function = function_of("def caller(x):\n    return x.helper\n", helper=function_of(HELPER, "helper"))
    assert references_of(function) == {}


def test_a_name_inside_of_a_comprehension_is_a_reference():
    function = function_of("def caller(x):\n    return [LIMIT * one for one in x]\n", LIMIT=3.0)
    assert references_of(function) == {"LIMIT": 3.0}
