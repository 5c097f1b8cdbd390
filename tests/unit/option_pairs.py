"""Pairwise testing: few cases that combine every value of an option with every value of every other option.

Most errors that depend on options depend on one or two of them (Kuhn, Wallace and Gallo 2004,
doi:10.1109/TSE.2004.24): the product of all options finds hardly more, with many times as many cases.
"""

from itertools import product


def every_pair(*options):
    """Return cases, one value of each option, that contain every pair of values of two options.

    The cases are the product of the first two options, best the longest ones, to which the others are added
    one at a time (Lei and Tai 1998, doi:10.1109/HASE.1998.731623).
    """
    cases = [list(case) for case in product(*(range(len(option)) for option in options[:2]))]
    for index, option in enumerate(options[2:], start=2):
        missing = {
            (earlier, other, value)
            for earlier in range(index)
            for other in range(len(options[earlier]))
            for value in range(len(option))
        }
        used = [0] * len(option)

        def pairs(case, value):
            return {(earlier, level, value) for earlier, level in enumerate(case)}

        for case in cases:
            # the value that adds most pairs; of equal ones the rarest
            best = max(
                range(len(option)), key=lambda value: (len(missing & pairs(case, value)), -used[value])
            )
            missing -= pairs(case, best)
            used[best] += 1
            case.append(best)
        for earlier, other, value in sorted(missing):
            cases.append([0] * index + [value])
            cases[-1][earlier] = other
    return [tuple(option[index] for option, index in zip(options, case, strict=True)) for case in cases]
