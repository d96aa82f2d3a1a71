#!/usr/bin/env bash
# Calibrate a two-wheel robot before it is built: is the square large enough for its floor?
# Usage: bash 02_two_wheel_robot.sh [VEHICLE.toml]
set -euo pipefail
vehicle=${1:-vehicle.toml}

# Which drive tells most about this robot, in a free space of 8 m by 6 m?
omnimate design --vehicle "$vehicle" --length 8 --width 6 | sed -n '1,12p'

# Simulate that UMBmark. The truth differs from the description by the errors that the UMBmark paper measured.
omnimate simulate squares --vehicle "$vehicle" --side 3 --runs 5 --seed 1 --start 1763670000

# Solve. `--out` writes the calibrated description, `--plot` the return errors before and after.
omnimate umbmark squares --out calibrated.toml --plot squares.svg | tail -8
