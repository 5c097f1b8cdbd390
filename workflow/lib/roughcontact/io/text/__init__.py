"""Text with numbers in it: what its header says, the table below it, and points put on their grid."""
