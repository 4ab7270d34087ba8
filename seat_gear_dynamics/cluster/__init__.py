"""Computing beyond one machine: points handed to a Dask cluster, and what must be alike for equal numbers."""
