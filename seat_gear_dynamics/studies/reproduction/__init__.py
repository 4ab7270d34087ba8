"""The paper's claims C1-C15, each measured on this model: expected, found, verdict and why."""
