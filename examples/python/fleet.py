# SPDX-License-Identifier: MIT
"""Health of a fleet as a table: python3 fleet.py RECORDING...; without arguments, of three simulated rigs."""
import sys

import limber

recordings = [limber.read(path) for path in sys.argv[1:]] or [
    limber.simulate(name, seed=3) for name in ("drone_none", "drone_rotation", "drone_constant")]

print(f"{'rig':<18}{'verdict':<15}{'since':>8}  moved")
for recording in recordings:
    health = limber.health(recording)
    found = health["health"] or {"present": {"axes": {}}}
    since = found.get("changed_s")
    moved = [name for name, axis in found["present"]["axes"].items() if axis["verdict"] in ("degraded", "decalibrated")]
    print(f"{recording.name:<18}{health.verdict:<15}{'' if since is None else f'{since:.1f} s':>8}  {', '.join(moved)}")
