"""`python -m benchmarks.peers [--short] [--form reduced]`: the peers alone."""

import argparse
import json
import sys

from benchmarks.peers.measure import measure


def main() -> None:
    """Measure and print one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="fewer periods and motions")
    parser.add_argument("--form", choices=("printed", "reduced"), default="printed", help="of the peers' equations")
    arguments = parser.parse_args()
    found = measure(short=arguments.short, form=arguments.form, progress=lambda line: print(line, file=sys.stderr))
    print(json.dumps(found.as_dict(), indent=1))


if __name__ == "__main__":
    main()
