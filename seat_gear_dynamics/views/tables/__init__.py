"""The numbers behind results' plots as columns with units; nothing here needs matplotlib."""
