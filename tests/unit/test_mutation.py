"""What the tool of mutation testing counts."""

from types import SimpleNamespace

import pytest

from tests.mutation.mutate import is_completed, is_killed


@pytest.mark.parametrize(
    ("outcome", "completed", "killed"),
    [("killed", True, True), ("survived", True, False), ("incompetent", False, False), (None, False, False)],
)
def test_a_run_that_was_interrupted_has_killed_nothing(outcome, completed, killed):
    result = SimpleNamespace(test_outcome=outcome, is_killed=outcome != "survived")
    assert (is_completed(result), is_killed(result)) == (completed, killed)
