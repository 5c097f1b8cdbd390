"""Read, level and cut out the window of one surface: a measured file to height.nc, levelled.nc, window.nc."""

from _job import check_sources, link
from _preparing import prepare

link()
prepare()
check_sources()
