"""Whether TensorBoard's own reader finds in exported event files what `metrics.csv` has.

    make tensorboard-test
    python event_files.py RUN EVENTS    # after: itarl export RUN --tensorboard EVENTS
"""

import csv
import math
import sys
from pathlib import Path

import numpy as np
from tensorboard.backend.event_processing.event_accumulator import SCALARS, EventAccumulator

run, events = map(Path, sys.argv[1:])
n_cells = n_values = 0
for metrics in sorted(run.glob("cells/*/seed=*/metrics.csv")):
    cell = metrics.parent.relative_to(run / "cells")
    with open(metrics, newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        continue
    read = EventAccumulator(str(events / cell), size_guidance={SCALARS: 0}).Reload()
    curves = {tag.split("/")[1]: read.Scalars(tag) for tag in read.Tags()["scalars"]}
    for column in rows[0].keys() - {"update", "control_steps"}:
        known = [row for row in rows if not math.isnan(float(row[column]))]
        expected = [(int(row["control_steps"]), np.float32(row[column])) for row in known]
        found = [(it.step, np.float32(it.value)) for it in curves.pop(column, [])]
        assert found == expected, f"{cell}: {column}: {found[:3]} in place of {expected[:3]}"
        n_values += len(found)
    # Cells from before there was this column have what it was made of.
    assert curves.keys() <= {"task"}, f"{cell}: {curves.keys()} aren't in metrics.csv"
    n_cells += 1
assert n_cells, f"{run}: no cell has an update"
print(f"{run}: {n_values} values of {n_cells} cells are those of metrics.csv")
