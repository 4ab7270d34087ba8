"""Questions asked of the model: harmonic balance, Taguchi, calibration, contact verification, the paper's claims."""
