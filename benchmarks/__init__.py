"""What the software costs, measured: `python -m benchmarks` runs all of it and says what changed since the last record.

No part of the package. Each module measures one thing and prints one JSON object when it is run by itself, as in
`python -m benchmarks.lanes`; README.md says what each of them measures and what was found last.
"""
