"""The error budget: the ± of the headline quantities, source by source.

The public function is in `budget`.
"""
