"""The lane kernel beside other people's integrators, on the same motions at the same error."""
