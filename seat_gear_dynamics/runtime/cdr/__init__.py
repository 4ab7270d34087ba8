"""Messages as CDR bytes: code generated once for each type, reading and writing."""
