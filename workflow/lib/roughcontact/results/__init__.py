"""Files and tables: whole or not at all, byte-identical, labelled."""
