"""The seat-ECU bench that the simulator plays: speed and load profiles, motor lag, Hall sensor, noise."""
