"""How good the warning is: labelled runs of a simulated bench through the monitor's session, and their scores."""
