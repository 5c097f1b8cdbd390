"""Whether pairwise testing leaves no pair of options out."""

from itertools import combinations, product

from option_pairs import every_pair


def test_every_pair_is_among_the_cases():
    for options in (
        ("abcd", (1, 2, 3), (True, False), (0.1, 0.2, 0.3)),
        ("ab", "ab", "ab", "ab", "abc"),  # more than the product of the first two
        (["only"], (1, 2, 3), "ab"),
    ):
        cases = every_pair(*options)
        for (i, values_i), (j, values_j) in combinations(enumerate(options), 2):
            assert {(case[i], case[j]) for case in cases} == set(product(values_i, values_j))
    assert len(every_pair("abcd", (1, 2, 3), (True, False), (0.1, 0.2, 0.3))) <= 14  # of 72
