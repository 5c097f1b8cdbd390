"""Profiles: the lay that is stated of them, and maps whose rows they are."""
