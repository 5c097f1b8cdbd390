"""The periodic window: which part of a map is solved, and how it is made periodic.

The public function is in `periodic_window`.
"""
