#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The docs site's settings name an undocumented member, and take a comment for all variables that are declared with it."""
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
HEADER = """#pragma once
/// An interval.
struct Interval {
  double low = 0.0, high = 0.0;  ///< [px]
  /// Of its
  /// ends.
  double sigma_low{1.0}, sigma_high{f(1.0, 2.0)};
  double first = 0.0,
      last = 0.0;  ///< a line
                   ///< and another
  int bare = 0;
  int width() const;
};
"""


def warnings_of(header):
    with tempfile.TemporaryDirectory() as name:
        headers, shown = Path(name) / "headers", Path(name) / "shown"
        headers.mkdir()
        (headers / "interval.hpp").write_text(header)
        subprocess.run([sys.executable, SOURCE / "docs/shared_comments.py", headers, shown], check=True)
        settings = (SOURCE / "docs/Doxyfile").read_text() + f'INPUT = "{shown}"\nOUTPUT_DIRECTORY = "{name}/site"\nGENERATE_HTML = NO\n'
        done = subprocess.run(["doxygen", "-"], input=settings, cwd=SOURCE, text=True, capture_output=True, check=True)
        return [line for line in done.stderr.splitlines() if "is not documented" in line]


def main():
    found = warnings_of(HEADER)
    named = [line.split("Member ")[1].split(" (")[0] for line in found]
    if sorted(named) != ["bare", "width() const"]:
        sys.exit("expected warnings of bare and width(), found:\n" + "\n".join(found))


if __name__ == "__main__":
    main()
