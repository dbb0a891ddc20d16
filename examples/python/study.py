# SPDX-License-Identifier: MIT
"""A study as a table: which method stands a rig that was bumped?"""
import pathlib
import tempfile

import limber

scenario = limber.Scenario(pathlib.Path(limber.__file__).parent / "scenarios" / "drone_constant.yaml")
scenario.duration = 5.0
with tempfile.TemporaryDirectory() as folder:
    study = limber.study(scenario, "ekf,ekf-full,lcekf", runs=3, seed=1, database=f"{folder}/study.sqlite")
    table = study.table()  # with pandas: pandas.DataFrame(table)

print(f"{'method':<10}{'position RMSE':>15}{'ANEES':>9}{'diverged':>10}")
for row in table:
    print(f"{row['method']:<10}{row['position_rmse_m']:>13.4f} m{row['anees']:>9.2f}{row['diverged']:>10}")
of = {row["method"]: row for row in table}
assert of["lcekf"]["anees"] < of["ekf"]["anees"]
