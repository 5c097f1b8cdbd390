"""The error budget: the ± of the headline numbers, source by source.

The verb is in `budget`.
"""
